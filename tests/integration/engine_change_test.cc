// A live world on a server changes its engine between two steps, and nobody can tell from its state or its events.
#include <map>

#include "conformance/engine_test.h"
#include "integration/live_server.h"

namespace genphys::testing {
namespace {

// Poses and velocities pass through the engine's own centre of mass and quaternion: rounding only.
constexpr double kSameState = 1e-12;
constexpr uint32_t kFlying = 30, kResting = 300;  // steps after which the ball flies, and lies on the crate
constexpr uint32_t kFiveSeconds = 300;            // steps
// m: the residual of a solver that works in sweeps lets a ball roll as far as this before it sleeps.
constexpr double kRestDifference = 3e-3;
constexpr double kStackTolerance = 5e-3;  // m

std::string Other(const std::string& engine) {
  for (const std::string& name : EnginesWithContacts()) {
    if (name != engine) return name;
  }
  return engine;
}

void ExpectSameState(const client::Frame& a, const client::Frame& b) {
  ASSERT_TRUE(std::equal(a.ids().begin(), a.ids().end(), b.ids().begin(), b.ids().end()));
  EXPECT_LE((a.positions() - b.positions()).cwiseAbs().maxCoeff(), kSameState);
  EXPECT_LE((a.orientations() - b.orientations()).cwiseAbs().maxCoeff(), kSameState);
  EXPECT_LE((a.linear_velocities() - b.linear_velocities()).cwiseAbs().maxCoeff(), kSameState);
  EXPECT_LE((a.angular_velocities() - b.angular_velocities()).cwiseAbs().maxCoeff(), kSameState);
}

// Counts what is announced and fails the test when a contact that goes on is announced again.
class ContactBook {
 public:
  void Add(const std::vector<Event>& events) {
    for (const Event& event : events) {
      if (const auto* began = std::get_if<ContactBegan>(&event.kind)) {
        EXPECT_EQ(++open_[began->pair], 1) << "at step " << event.step;
        ++began_[began->pair];
      }
      if (const auto* ended = std::get_if<ContactEnded>(&event.kind)) {
        EXPECT_EQ(--open_[ended->pair], 0) << "at step " << event.step;
      }
    }
  }
  const std::map<EntityPair, int>& began() const { return began_; }

 private:
  std::map<EntityPair, int> open_;
  std::map<EntityPair, int> began_;
};

struct Scene {
  client::World world;
  EntityId ball;

  // `x` at which the ball falls: beside the middle of the crate it rolls away in the end, near the middle it stays.
  Scene(const client::Server& server, const std::string& engine, double x)
      : world(Value(server.CreateWorld(WorldOn(engine)))) {
    Value(world.Add(Box{{0.5, 0.5, 0.5}}, {.position = {0, 0, 0.5}, .mass = 1}));
    ball = Value(world.Add(Sphere{0.5}, {.position = {x, 0, 5}, .mass = 1}));
  }

  client::StepResult Step(uint32_t steps) { return Value(world.Step(steps)); }
  client::StepResult ChangeTo(const std::string& engine) {
    return Value(world.Step(0, {.commands = {SetEngine{engine}}}));
  }
};

class LiveEngineChange : public ::testing::TestWithParam<std::tuple<std::string, uint32_t>> {
 protected:
  const std::string& engine() const { return std::get<0>(GetParam()); }
  uint32_t step() const { return std::get<1>(GetParam()); }
  Scene MakeScene(const std::string& engine) { return Scene(connection_, engine, 0.3); }

  LiveServer server_;
  client::Server connection_ = server_.Connect();
};

INSTANTIATE_TEST_SUITE_P(Engines, LiveEngineChange,
                         ::testing::Combine(::testing::ValuesIn(EnginesWithContacts()),
                                            ::testing::Values(kFlying, kResting)),
                         [](const auto& test) {
                           return std::get<0>(test.param) +
                                  (std::get<1>(test.param) == kFlying ? "_flying" : "_resting");
                         });

TEST_P(LiveEngineChange, KeepsPosesAndVelocities) {
  Scene scene = MakeScene(engine());
  const client::StepResult before = scene.Step(step());

  for (const std::string& next : {Other(engine()), engine(), std::string("none"), engine()}) {
    const client::StepResult after = scene.ChangeTo(next);
    EXPECT_EQ(Value(scene.world.Info()).world.engine, next);
    EXPECT_EQ(after.stamp.step, before.stamp.step);
    ExpectSameState(before.frame, after.frame);
  }
}

TEST_P(LiveEngineChange, AnnouncesNoContactTwice) {
  Scene scene = MakeScene(engine());
  client::EventStream stream = Value(scene.world.WatchEvents());
  ContactBook book;
  client::StepResult last = scene.Step(step());

  for (const std::string& next : {Other(engine()), engine(), std::string("none"), engine()}) {
    scene.ChangeTo(next);
    last = scene.Step(90);
  }

  book.Add(ReadEvents(stream, last.last_sequence));
  ASSERT_EQ(book.began().size(), 2u) << "crate and floor, ball and crate";
  for (const auto& [pair, count] : book.began()) EXPECT_EQ(count, 1);
}

TEST_P(LiveEngineChange, LeavesTheBallWhereItIsWithoutTheChange) {
  Scene changed = MakeScene(engine()), same = MakeScene(engine()), other = MakeScene(Other(engine()));
  for (Scene* scene : {&changed, &same, &other}) scene->Step(step());

  changed.ChangeTo(Other(engine()));
  for (Scene* scene : {&changed, &same, &other}) scene->Step(60);
  changed.ChangeTo("none");
  changed.ChangeTo(engine());
  const Vector3 place = PositionIn(changed.Step(kFiveSeconds).frame, changed.ball);

  const Vector3 expected = PositionIn(same.Step(kFiveSeconds).frame, same.ball);
  const double engines_differ = (PositionIn(other.Step(kFiveSeconds).frame, other.ball) - expected).norm();
  EXPECT_LE((place - expected).norm(), engines_differ + kRestDifference);
}

TEST_P(LiveEngineChange, ToNoEngineStopsTheWorldAndBackLetsItGoOn) {
  Scene scene = MakeScene(engine()), same = MakeScene(engine());
  const client::StepResult before = scene.Step(step());
  same.Step(step());

  scene.ChangeTo("none");
  const client::StepResult frozen = scene.Step(20);
  ExpectSameState(before.frame, frozen.frame);
  EXPECT_EQ(frozen.stamp.step, before.stamp.step + 20) << "time goes on";
  EXPECT_TRUE(Of<ContactEnded>(frozen.events).empty());
  scene.ChangeTo(engine());

  const Vector3 place = PositionIn(scene.Step(kFiveSeconds).frame, scene.ball);
  const Vector3 expected = PositionIn(same.Step(kFiveSeconds).frame, same.ball);
  EXPECT_LE((place - expected).norm(), kRestDifference);
}

class LiveAlternation : public EngineTest {};

INSTANTIATE_TEST_SUITE_P(Engines, LiveAlternation, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

TEST_P(LiveAlternation, OfEnginesAtEachStepLetsAStackStand) {
  const LiveServer server;
  client::World world = Value(server.Connect().CreateWorld(WorldOn(GetParam())));
  std::vector<EntityId> boxes;
  for (int i = 0; i < 5; ++i) {
    EntityDesc box = Crate({0, 0, 0.5 + i});
    box.rigid_body->auto_disable.enabled = false;  // a sleeping stack would prove nothing
    boxes.push_back(Value(world.Create(box)));
  }

  ContactBook book;
  client::StepResult result;
  for (int step = 0; step < 600; ++step) {
    result = Value(world.Step(1, {.commands = {SetEngine{step % 2 == 0 ? Other(GetParam()) : GetParam()}}}));
    book.Add(result.events);
  }

  for (size_t i = 0; i < boxes.size(); ++i) {
    const Vector3 place(0, 0, 0.5 + static_cast<double>(i));
    EXPECT_LE((PositionIn(result.frame, boxes[i]) - place).norm(), kStackTolerance) << "box " << i;
  }
  EXPECT_EQ(book.began().size(), 5u);
  for (const auto& [pair, count] : book.began()) EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace genphys::testing

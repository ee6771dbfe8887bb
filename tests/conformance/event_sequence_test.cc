// Scenes whose impacts are well apart tell the same story on every engine, and one engine tells it to the last byte.
#include <cmath>
#include <thread>

#include "conformance/engine_test.h"
#include "genphys/wire/encode.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(EventSequences, Claim::kContactEvents, Claim::kEnginesAgree);

constexpr double kGravity = 9.81;
constexpr double kStep = 1.0 / 60;
constexpr uint64_t kSeeds = 8;

struct Told {
  size_t kind;
  EntityPair who;
  uint64_t step;
};

std::vector<Told> StoryOf(const std::vector<Event>& events) {
  std::vector<Told> story;
  for (const Event& event : events) story.push_back({event.kind.index(), EntitiesOf(event.kind), event.step});
  return story;
}

std::string BytesOf(const std::vector<Event>& events) {
  std::string bytes;
  for (const Event& event : events) {
    v1::Event message;
    EncodeEvent(event, &message);
    message.AppendToString(&bytes);
  }
  return bytes;
}

std::vector<Event> Run(World& world, int steps) {
  std::vector<Event> events = world.TakeEvents();
  for (int i = 0; i < steps; ++i) {
    Steps(world, 1);
    for (Event& event : world.TakeEvents()) events.push_back(std::move(event));
  }
  return events;
}

WorldDesc Telling(const std::string& engine, const Vector3& gravity) {
  return {.engine = engine, .gravity = gravity, .recorded_events = {.persisting_contacts = false, .moving = true}};
}

// What `engines` can drop flat on a floor, and how high its origin then lies.
std::vector<std::pair<Shape, double>> FlatFallers(const std::vector<std::string>& engines) {
  const std::vector<std::pair<Shape, double>> all{{Sphere{0.4}, 0.4},
                                                  {Box{{0.3, 0.4, 0.2}}, 0.2},
                                                  {Cylinder{0.4, 0.3}, 0.3},
                                                  {Cone{0.5, 0.4}, 0.4},
                                                  {HullBox({0.4, 0.3, 0.3}), 0.3}};
  std::vector<std::pair<Shape, double>> able;
  for (const auto& faller : all) {
    const bool can = std::all_of(engines.begin(), engines.end(), [&](const std::string& engine) {
      return EveryEngine().Find(engine)->capabilities().Has(FeatureOf(faller.first));
    });
    if (can) able.push_back(faller);
  }
  return able;
}

// Bodies that land one after the other, some in a gate on the way, lie and fall asleep.
std::vector<Event> Rain(const std::string& engine, const std::string& other, uint64_t seed) {
  Random random(seed);
  const auto world = MakeWorld(Telling(engine, {0, 0, -kGravity}));
  const auto fallers = FlatFallers({engine, other});
  for (int i = 0; i < 8; ++i) {
    const auto& [shape, height] = fallers[random.Below(fallers.size())];
    // Impacts are nine steps apart, give or take two.
    const double lands = (12 + 9 * i + random.Uniform(-2, 2)) * kStep;
    const double x = 5.0 * i, y = random.Uniform(-3, 3), top = height + kGravity * lands * lands / 2;
    EntityDesc body = Body(shape, {x, y, top}, random.LogUniform(1e-2, 1e2));
    body.pose.orientation = Eigen::AngleAxisd(random.Uniform(-3, 3), Vector3::UnitZ());
    body.rigid_body->geometries[0].material.restitution = 0;
    Add(*world, body);
    // Left well before the ground is reached.
    if (0.6 * (top - height) > 1.2) {
      EntityDesc gate = Ball({x, y, height + 0.6 * (top - height)}, 0.2);
      gate.rigid_body->motion_type = MotionType::kStatic;
      gate.rigid_body->geometries[0].is_sensor = true;
      Add(*world, gate);
    }
  }
  return Run(*world, 240);
}

// Without gravity: each ball of a row hits the next one, at a distance that takes it more than ten steps.
std::vector<Event> Billiards(const std::string& engine, const std::string&, uint64_t seed) {
  Random random(seed);
  const auto world = MakeWorld(Telling(engine, Vector3::Zero()));
  const Vector3 along = random.Direction().cwiseAbs();
  Vector3 place(0, 0, 10);
  for (int i = 0; i < 6; ++i) {
    EntityDesc ball = Ball(place, 0.25, 2);
    ball.rigid_body->geometries[0].material.restitution = 1;
    ball.rigid_body->geometries[0].material.friction = 0;
    if (i == 0) ball.rigid_body->linear_velocity = 3 * along;
    Add(*world, ball);
    place += random.Uniform(1.1, 2) * along;
  }
  return Run(*world, 240);
}

// On `engine`, with what `other` can do as well.
using MakeEvents = std::vector<Event> (*)(const std::string& engine, const std::string& other, uint64_t seed);
constexpr MakeEvents kScenes[] = {Rain, Billiards};

enum class Chapter { kImpacts, kGates, kMotion, kRest, kUntold };

// Rest begins when an engine has taken away what an impact left, which takes each its own time: what is told of that
// may come before or after what is told of another body. So these are compared body by body.
Chapter ChapterOf(const Event& event) {
  if (std::holds_alternative<EntitySlept>(event.kind) || std::holds_alternative<EntityWoke>(event.kind)) {
    return Chapter::kRest;
  }
  // Nothing keeps one body's way through a gate apart from another one's impact.
  if (std::holds_alternative<SensorEntered>(event.kind) || std::holds_alternative<SensorLeft>(event.kind)) {
    return Chapter::kGates;
  }
  const auto* started = std::get_if<EntityStartedMoving>(&event.kind);
  const auto* stopped = std::get_if<EntityStoppedMoving>(&event.kind);
  if (started == nullptr && stopped == nullptr) return Chapter::kImpacts;
  // How evenly four corners share a blow, and so whether it makes a box tremble, is a matter of the solver's sweeps.
  return started != nullptr ? (started->rotation ? Chapter::kUntold : Chapter::kMotion)
                            : (stopped->rotation ? Chapter::kUntold : Chapter::kMotion);
}

std::vector<Told> ChapterOf(const std::vector<Event>& events, Chapter chapter) {
  std::vector<Event> chosen;
  for (const Event& event : events) {
    if (ChapterOf(event) == chapter) chosen.push_back(event);
  }
  std::vector<Told> story = StoryOf(chosen);
  if (chapter == Chapter::kMotion || chapter == Chapter::kRest) {
    std::stable_sort(story.begin(), story.end(), [](const Told& a, const Told& b) { return a.who < b.who; });
  }
  return story;
}

TEST_P(EventSequences, AreTheSameOnEveryEngine) {
  Proves({Claim::kSleepEvents, Claim::kMotionEvents, Claim::kSensorEvents});
  // Where an engine finds the surfaces decides the step of an impact.
  constexpr uint64_t kLate = 1;  // steps
  for (const MakeEvents make : kScenes) {
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const std::string other_engine = OtherEngine(GetParam());
      const std::vector<Event> here = make(GetParam(), other_engine, seed),
                               there = make(other_engine, GetParam(), seed);
      for (const Chapter chapter : {Chapter::kImpacts, Chapter::kGates, Chapter::kMotion, Chapter::kRest}) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << " chapter " << static_cast<int>(chapter));
        const std::vector<Told> story = ChapterOf(here, chapter), other = ChapterOf(there, chapter);
        ASSERT_EQ(story.size(), other.size());
        for (size_t i = 0; i < story.size(); ++i) {
          EXPECT_EQ(story[i].kind, other[i].kind) << "event " << i << " of step " << story[i].step;
          EXPECT_EQ(story[i].who, other[i].who) << "event " << i << " of step " << story[i].step;
          if (chapter == Chapter::kMotion || chapter == Chapter::kRest) continue;
          EXPECT_LE(std::max(story[i].step, other[i].step) - std::min(story[i].step, other[i].step), kLate) << i;
        }
        if (HasFailure()) return;
      }
      EXPECT_GT(here.size(), 15u);
    }
  }
}

TEST_P(EventSequences, AreInOrderOfStepKindAndPair) {
  Proves({Claim::kEventOrder});
  for (const MakeEvents make : kScenes) {
    const std::vector<Event> events = make(GetParam(), GetParam(), 3);
    const std::vector<Told> story = StoryOf(events);
    uint64_t commands = 0;  // are told in their own order
    for (size_t i = 1; i < story.size(); ++i) {
      EXPECT_EQ(events[i].sequence, events[i - 1].sequence + 1);
      commands += story[i].step == 0;
      if (story[i].step == 0) continue;
      EXPECT_LE(std::tie(story[i - 1].step, story[i - 1].kind, story[i - 1].who),
                std::tie(story[i].step, story[i].kind, story[i].who));
    }
    EXPECT_LT(commands, story.size());
  }
}

TEST_P(EventSequences, HaveTheSameBytesAgainAndOnOtherThreads) {
  Proves({Claim::kEventOrder});
  for (const MakeEvents make : kScenes) {
    const std::string first = BytesOf(make(GetParam(), GetParam(), 5));
    EXPECT_GT(first.size(), 500u);
    EXPECT_EQ(BytesOf(make(GetParam(), GetParam(), 5)), first);
    std::string one, other;
    std::thread beside([&] { other = BytesOf(make(GetParam(), GetParam(), 5)); });
    one = BytesOf(make(GetParam(), GetParam(), 5));
    beside.join();
    EXPECT_EQ(one, first);
    EXPECT_EQ(other, first);
  }
}

}  // namespace
}  // namespace genphys::testing

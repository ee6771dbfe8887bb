// A live world changes its engine between two steps and nobody can tell from its state or its events.
#include <cmath>
#include <map>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(EngineChange, Claim::kEngineChange);

// Poses and velocities pass through the engine's own centre of mass and quaternion.
constexpr double kSameState = kRounded;

constexpr double kGravity = 9.81, kStep = 1.0 / 60;
constexpr double kBlow = 0.849746;  // s: when the ball meets the crate, see crate_and_ball_test.cc

void ExpectSameColumns(const StateArrays& a, const StateArrays& b) {
  ASSERT_EQ(a.ids, b.ids);
  EXPECT_LE((a.positions - b.positions).cwiseAbs().maxCoeff(), kSameState);
  EXPECT_LE((a.orientations - b.orientations).cwiseAbs().maxCoeff(), kSameState);
  EXPECT_LE((a.linear_velocities - b.linear_velocities).cwiseAbs().maxCoeff(), kSameState);
  EXPECT_LE((a.angular_velocities - b.angular_velocities).cwiseAbs().maxCoeff(), kSameState);
}

struct Scene {
  std::unique_ptr<World> world;
  EntityId ball;
};

Scene MakeScene(const std::string& engine) {
  Scene scene{MakeWorld(engine), {}};
  Add(*scene.world, Crate({0, 0, 0.5}));
  scene.ball = Add(*scene.world, Ball({0.7, 0, 5}));
  return scene;
}

// Steps at which the ball flies, and at which it rolls on the floor while the crate rests.
class EngineChangeAt : public EveryEngineTest<std::tuple<std::string, int>> {
  void SetUp() override {
    EveryEngineTest::SetUp();
    Proves({Claim::kEngineChange});
  }
};

TEST_P(EngineChangeAt, KeepsPosesAndVelocities) {
  const auto& [engine, step] = GetParam();
  Scene scene = MakeScene(engine);
  Steps(*scene.world, step);
  const StateArrays before = scene.world->state();

  for (const std::string& next : {OtherEngine(engine), std::string("none"), engine}) {
    Do(*scene.world, SetEngine{next});
    ExpectSameColumns(before, scene.world->state());
  }
}

TEST_P(EngineChangeAt, TellsNoContactTwice) {
  const auto& [engine, step] = GetParam();
  Scene scene = MakeScene(engine);
  std::vector<Event> events;
  const auto gather = [&](int steps) {
    Steps(*scene.world, steps);
    for (Event& event : scene.world->TakeEvents()) events.push_back(std::move(event));
  };
  gather(step);
  for (const std::string& next : {OtherEngine(engine), engine}) {
    Do(*scene.world, SetEngine{next});
    gather(60);
  }

  std::map<EntityPair, int> open;
  for (const Event& event : events) {
    if (const auto* began = std::get_if<ContactBegan>(&event.kind)) {
      EXPECT_EQ(++open[began->pair], 1);
    }
    if (const auto* ended = std::get_if<ContactEnded>(&event.kind)) {
      EXPECT_EQ(--open[ended->pair], 0);
    }
  }
  EXPECT_EQ(open.size(), 3u) << "crate and floor, ball and crate, ball and floor";
}

TEST_P(EngineChangeAt, LeavesTheBallWhereItWouldHaveBeen) {
  const auto& [engine, step] = GetParam();
  Scene changed = MakeScene(engine), same = MakeScene(engine), other = MakeScene(OtherEngine(engine));
  for (Scene* scene : {&changed, &same, &other}) Steps(*scene->world, step);
  Do(*changed.world, SetEngine{OtherEngine(engine)});
  for (Scene* scene : {&changed, &same, &other}) Steps(*scene->world, 60);
  Do(*changed.world, SetEngine{engine});
  for (Scene* scene : {&changed, &same, &other}) Steps(*scene->world, 240);

  // It rolls wherever the engine is changed but for the first time: who had the blow decides, and rolling leaves what
  // sweeps leave of friction.
  const bool blow_was_changed = step * kStep < kBlow;
  const Scene& expected = blow_was_changed ? other : same;
  const Vector3 apart = PositionOf(*changed.world, changed.ball) - PositionOf(*expected.world, expected.ball);
  const double slip = 2 * SweptSpeed(0.5 * kGravity, SubstepOf(*changed.world));
  EXPECT_LE(apart.norm(), slip * (60 + 240) * kStep);
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineChangeAt,
                         ::testing::Combine(::testing::ValuesIn(EveryEngineName()), ::testing::Values(30, 240)),
                         [](const auto& made) {
                           return std::get<0>(made.param) + "_" + std::to_string(std::get<1>(made.param));
                         });

TEST_P(EngineChange, NothingMovesOnNoEngine) {
  Scene scene = MakeScene(GetParam());
  Steps(*scene.world, 30);
  const StateArrays before = scene.world->state();

  Do(*scene.world, SetEngine{"none"});
  Steps(*scene.world, 10);
  ExpectSameColumns(before, scene.world->state());
  Do(*scene.world, SetEngine{GetParam()});
  Steps(*scene.world, 1);

  EXPECT_LT(PositionOf(*scene.world, scene.ball).z(), before.positions(2, scene.ball.index()));
}

TEST_P(EngineChange, IsRefusedWithTheListOfWhatIsMissingAndChangesNothing) {
  const auto world = MakeWorld();
  const EntityId ball = Add(*world, Ball({0, 0, 5}));
  Add(*world, Body(HullBox({0.5, 0.5, 0.5}), {3, 0, 0.5}));
  EntityDesc gate = Block({0, 0, 3}, {1, 1, 0.1});
  gate.rigid_body->geometries[0].is_sensor = true;
  Add(*world, gate);
  Join(*world, ToWorld(ball, HingeJoint{}));
  Steps(*world, 10);
  const uint64_t before = world->StateHash();

  const Command command = SetEngine{"ballistic"};
  const Status status = world->Apply({&command, 1}).status();

  ASSERT_TRUE(RefusalOf(status));
  EXPECT_EQ(RefusalOf(status)->reason, Reason::kUnsupportedFeature);
  EXPECT_EQ(RefusalOf(status)->field, "commands[0].set_engine.engine");
  EXPECT_TRUE(MessageOf(status).ends_with("shape_plane, shape_convex_hull, sensors, joint_hinge")) << status;
  EXPECT_EQ(world->StateHash(), before);
  Steps(*world, 10);
}

// Engines take substeps of different lengths and find other points: what held a body is scaled and shared out anew.
TEST_P(EngineChange, ATowerOfTenHardlyFeelsIt) {
  for (const Quality quality : {Quality::kBalanced, Quality::kAccurate}) {
    const std::unique_ptr<World> world = testing::MakeWorld(OtherEngine(GetParam()));
    Do(*world, SetStepper{{.quality = quality}});
    std::vector<EntityId> boxes;
    for (int i = 0; i < 10; ++i) {
      EntityDesc box = Crate({0, 0, 0.5 + i});
      box.rigid_body->auto_disable.enabled = false;  // a sleeping tower would prove nothing
      boxes.push_back(Add(*world, box));
    }
    Steps(*world, 240);
    const StateArrays before = world->state();
    Do(*world, SetEngine{GetParam()});
    // It goes on lying still: at no more than counts as rest, and where it touched.
    constexpr double kAtRest = 0.02;  // m/s
    for (int i = 0; i < 30; ++i) {
      Steps(*world, 1);
      for (size_t j = 0; j < boxes.size(); ++j) {
        const Vector3 place = before.positions.col(boxes[j].index());
        EXPECT_LE(VelocityOf(*world, boxes[j]).norm(), kAtRest) << static_cast<int>(quality);
        EXPECT_LE((PositionOf(*world, boxes[j]) - place).norm(), static_cast<double>(j + 1) * kTouch) << j;
      }
    }
  }
}

TEST_P(EngineChange, AStackStandsOnADifferentEngineForEachStep) {
  const std::unique_ptr<World> world = MakeWorld();
  std::vector<EntityId> boxes;
  for (int i = 0; i < 5; ++i) {
    EntityDesc box = Crate({0, 0, 0.5 + i});
    box.rigid_body->auto_disable.enabled = false;  // a sleeping stack would prove nothing
    boxes.push_back(Add(*world, box));
  }
  std::map<EntityPair, int> began;
  for (int step = 0; step < 600; ++step) {
    Do(*world, SetEngine{step % 2 == 0 ? OtherEngine(GetParam()) : GetParam()});
    Steps(*world, 1);
    for (const ContactBegan& event : Of<ContactBegan>(world->TakeEvents())) ++began[event.pair];
  }
  for (int i = 0; i < 5; ++i) {
    EXPECT_LE((PositionOf(*world, boxes[static_cast<size_t>(i)]) - Vector3(0, 0, 0.5 + i)).norm(), (i + 1) * kTouch)
        << "box " << i;
  }
  EXPECT_EQ(began.size(), 5u);
  for (const auto& [pair, count] : began) EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace genphys::testing

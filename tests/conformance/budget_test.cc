// A step that needs more than its world may use leaves no trace, and the world goes on.
#include <algorithm>
#include <array>

#include "conformance/engine_test.h"
#include "genphys/limits.h"
#include "support/random_scene.h"
#include "support/state_bytes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Budget, Claim::kBudget);

constexpr uint64_t kScenes = 40;
constexpr int kStepsOfScene = 60;

Reason ReasonOf(const Status& status) { return RefusalOf(status).value_or(Refusal{}).reason; }

// Twins from the same seed, of which one is told to do with less now and then.
struct Twins {
  Twins(const std::string& engine, uint64_t seed)
      : free(MakeRandomScene({engine}, seed)), bound(MakeRandomScene({engine}, seed)) {}

  void Command(Random& random) {
    std::vector<genphys::Command> commands;
    for (const std::optional<SceneEntity>& entity : free.world->scene().entities) {
      if (!entity || !entity->desc->rigid_body || !random.Chance(0.1)) continue;
      const Vector3 near = PositionOf(*free.world, entity->id) + random.Vector(1);
      switch (entity->desc->rigid_body->motion_type) {
        case MotionType::kStatic:
          break;
        case MotionType::kKinematic:
          // Some of them are too far away to be led there, others go to where somebody sleeps.
          commands.push_back(SetPose{.id = entity->id,
                                     .position = random.Chance(0.2)   ? Vector3(near + Vector3(0, 1e5, 0))
                                                 : random.Chance(0.5) ? PositionOf(*free.world, SleeperOf(random))
                                                                      : near,
                                     .over_steps = static_cast<uint32_t>(random.Below(4))});
          break;
        case MotionType::kDynamic:
          commands.push_back(SetVelocity{entity->id, random.Vector(5), random.Vector(5)});
          break;
      }
    }
    for (RandomScene* scene : {&free, &bound}) ASSERT_TRUE(scene->world->Apply(commands).ok());
  }

  EntityId SleeperOf(Random& random) const { return free.sleepers[random.Below(free.sleepers.size())]; }

  RandomScene free, bound;
};

TEST_P(Budget, AStepThatMayNotBeginLeavesNoTrace) {
  size_t refused = 0, woken = 0;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Twins twins(GetParam(), seed);
    World& world = *twins.bound.world;
    Random random(seed ^ 0xb0d6e7);
    for (int step = 0; step < kStepsOfScene; ++step) {
      if (step % 10 == 5) twins.Command(random);
      world.TakeEvents();
      const uint64_t before = world.StateHash();
      const std::string all_but_engine = AllButTheEngineOf(world);
      world.set_budget({0, 0});
      const Status status = world.Step();
      world.set_budget({});
      if (!status.ok()) {
        ++refused;
        ASSERT_EQ(ReasonOf(status), Reason::kBudgetExceeded) << status;
        ASSERT_TRUE(AllButTheEngineOf(world) == all_but_engine) << "step " << step;
        ASSERT_TRUE(world.TakeEvents().empty());
        // Where nothing is near it may begin, and what comes of a solve is too much.
        if (MessageOf(status).find("the engine began anew") != std::string::npos) break;
        ASSERT_EQ(world.StateHash(), before) << "step " << step;
        ASSERT_FALSE(world.faulted());
        Steps(world, 1);
        woken += Of<EntityWoke>(world.TakeEvents()).size();
      }
      Steps(*twins.free.world, 1);
      ASSERT_EQ(world.StateHash(), twins.free.world->StateHash()) << "step " << step;
    }
  }
  EXPECT_GT(refused, kScenes * kStepsOfScene / 3);
  EXPECT_GT(woken, 0u) << "of steps that had to be undone, too";
}

TEST_P(Budget, AStepThatGrowsTooFarIsUndoneAndItsWorldGoesOn) {
  size_t refused = 0;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Twins twins(GetParam(), seed);
    World& world = *twins.bound.world;
    Random random(seed ^ 0xb0d6e7);
    for (int step = 0; step < kStepsOfScene; ++step) {
      if (step % 10 == 5) twins.Command(random);
      const std::string before = AllButTheEngineOf(world);
      const size_t points = world.contacts().points.size();
      world.set_budget({Limits::kNearPairsMax, points});
      const Status status = world.Step();
      world.set_budget({});
      if (status.ok()) continue;
      ++refused;
      ASSERT_EQ(ReasonOf(status), Reason::kBudgetExceeded) << status;
      ASSERT_TRUE(AllButTheEngineOf(world) == before) << "step " << step;
      Steps(world, 1);
    }
    ASSERT_FALSE(world.faulted());
    ASSERT_TRUE(world.state().positions.allFinite() && world.state().linear_velocities.allFinite());
  }
  EXPECT_GT(refused, kScenes);
}

// Two balls in one place, for which there is too little now and then.
struct Crowded {
  explicit Crowded(const std::string& engine) : world(MakeWorld(engine)) {
    for (EntityId& ball : balls) ball = Add(*world, Ball({0, 0, 5}));
  }
  void RefuseAStep() const {
    world->set_budget({0, 0});
    EXPECT_EQ(ReasonOf(world->Step()), Reason::kBudgetExceeded);
    world->set_budget({});
  }

  std::unique_ptr<World> world;
  std::array<EntityId, 2> balls;
};

TEST_P(Budget, AFirstStepThatIsUndoneIsNoBeginningToComeBackTo) {
  const Crowded crowded(GetParam());
  World& world = *crowded.world;
  crowded.RefuseAStep();
  // As it is told to.
  Do(world, DeleteEntity{crowded.balls[1]});
  const EntityId late = Add(world, Ball({9, 0, 5}));
  const uint64_t before = world.StateHash();

  for (const int steps : {0, 5}) {
    Steps(world, steps);
    world.Reset();
    EXPECT_EQ(world.layer_state().step, 0u);
    EXPECT_EQ(RefusalOf(world.CheckId(crowded.balls[1], "")).value_or(Refusal{}).reason, Reason::kStaleId);
    EXPECT_TRUE(world.CheckId(late, "").ok());
    EXPECT_EQ(world.StateHash(), before) << "after " << steps << " steps";
  }
}

TEST_P(Budget, AStepThatIsUndoneIsNoneInWhichALiftStood) {
  Proves({Claim::kMotionTypes});
  const Crowded bound(GetParam()), free(GetParam());
  for (const Crowded* each : {&bound, &free}) {
    World& world = *each->world;
    EntityDesc floor = Crate({20, 0, 5});
    floor.rigid_body->motion_type = MotionType::kKinematic;
    floor.rigid_body->linear_velocity = {0, 0, 1};
    const EntityId lift = Add(world, floor);
    Steps(world, 5);
    Do(world, SetVelocity{.id = lift, .linear = Vector3(0, 0, 0)});
    if (each == &bound) each->RefuseAStep();
    Do(world, SetVelocity{.id = lift, .linear = Vector3(0, 0, 1)});
    Steps(world, 1);
  }
  EXPECT_TRUE(AllButTheEngineOf(*bound.world) == AllButTheEngineOf(*free.world));
}

// Memory grows with the square of how many lie in one place.
TEST_P(Budget, OfMorePairsThanFitIntoMemoryIsRefusedUntilSomeAreGone) {
  const auto world = MakeWorld();
  const auto needed = static_cast<size_t>(std::sqrt(2.0 * Limits::kNearPairsMax)) + 2;
  std::vector<Command> commands(needed, CreateEntity{Ball({0, 0, 5}, 0.5)});
  const Result<std::vector<CreatedId>> ids = world->Apply(commands);
  ASSERT_TRUE(ids.ok());
  const uint64_t before = world->StateHash();
  for (int i = 0; i < 2; ++i) {
    const Status status = world->Step();
    EXPECT_EQ(ReasonOf(status), Reason::kBudgetExceeded);
    EXPECT_NE(status.message().find("1000000 pairs of geometries"), std::string_view::npos) << status;
    EXPECT_EQ(world->StateHash(), before);
  }
  commands.clear();
  for (size_t i = 10; i < needed; ++i) commands.push_back(DeleteEntity{EntityId::FromPacked((*ids)[i].packed())});
  ASSERT_TRUE(world->Apply(commands).ok());
  Steps(*world, 10);
  EXPECT_EQ(world->layer_state().step, 10u);
}

TEST_P(Budget, OfMorePointsThanFitIntoMemoryIsRefusedUntilSomeAreGone) {
  const auto world = MakeWorld();
  Require(*world, Feature::kShapeBox);
  // Each two of them meet at four points or more.
  const auto needed = static_cast<size_t>(std::sqrt(2.0 * Limits::kContactPointsMax / 4)) + 2;
  std::vector<Command> commands(needed, CreateEntity{Crate({0, 0, 5})});
  const Result<std::vector<CreatedId>> ids = world->Apply(commands);
  ASSERT_TRUE(ids.ok()) << ids.status();
  const uint64_t before = world->StateHash();
  const Status status = world->Step();
  EXPECT_EQ(ReasonOf(status), Reason::kBudgetExceeded);
  EXPECT_NE(status.message().find("1000000 points"), std::string_view::npos) << status;
  EXPECT_EQ(world->StateHash(), before);
  commands.clear();
  for (size_t i = 10; i < needed; ++i) commands.push_back(DeleteEntity{EntityId::FromPacked((*ids)[i].packed())});
  ASSERT_TRUE(world->Apply(commands).ok());
  Steps(*world, 10);
}

}  // namespace
}  // namespace genphys::testing

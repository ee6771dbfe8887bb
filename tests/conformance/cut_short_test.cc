// Work that nobody waits for any more ends soon and leaves a world that can be told.
#include <algorithm>

#include "conformance/engine_test.h"
#include "genphys/limits.h"
#include "genphys/work_watch.h"
#include "support/random_scene.h"
#include "support/shapes.h"
#include "support/state_bytes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(CutShortly, Claim::kBudget);

// Asked for the `last` time it has enough.
WorkWatch::Check EnoughAt(int& asked, int last) {
  return [&asked, last] { return ++asked >= last ? absl::CancelledError("enough") : absl::OkStatus(); };
}

EntityDesc Still(const Shape& shape, const Vector3& position) {
  EntityDesc desc = Body(shape, position);
  desc.rigid_body->motion_type = MotionType::kStatic;
  return desc;
}

std::vector<Command> SomeCommands(const std::string& engine) {
  std::vector<Command> commands;
  for (int i = 0; i < 4; ++i) {
    commands.push_back(CreateEntity{Ball({0.7 * i, 0, 3}, 0.5)});
    commands.push_back(SetGravity{{0, 0, -9.0 - i}});
    commands.push_back(CreateEntity{Still(Sphere{0.5}, {0.9 * i, 0, 0.5})});
    commands.push_back(SetEngine{i % 2 == 0 ? "none" : engine});
  }
  return commands;
}

TEST_P(CutShortly, ABatchIsEitherNotBegunOrDoneUpToACommand) {
  const std::vector<Command> commands = SomeCommands(GetParam());
  size_t begun = 0;
  for (int last = 1;; ++last) {
    const auto world = MakeWorld(), other = MakeWorld();
    for (World* each : {world.get(), other.get()}) {
      Add(*each, Ball({0, 0, 0.5}, 0.5));
      Steps(*each, 3);
    }
    const uint64_t before = world->StateHash();
    int asked = 0;
    Result<std::vector<CreatedId>> created = absl::UnknownError("");
    {
      const WorkWatch watch(EnoughAt(asked, last), 1);
      created = world->Apply(commands);
    }
    if (!created.ok()) {
      ASSERT_EQ(begun, 0u);
      ASSERT_EQ(created.status().code(), absl::StatusCode::kCancelled);
      ASSERT_EQ(world->StateHash(), before);
      continue;
    }
    if (asked < last) {
      EXPECT_EQ(created->size(), commands.size());
      break;
    }
    ASSERT_EQ(created->size(), ++begun);
    ASSERT_TRUE(other->Apply(std::span(commands).first(begun)).ok());
    ASSERT_EQ(world->StateHash(), other->StateHash()) << begun;
    for (World* each : {world.get(), other.get()}) Steps(*each, 5);
    ASSERT_EQ(world->StateHash(), other->StateHash()) << begun;
  }
  EXPECT_EQ(begun, commands.size() - 1);
}

TEST_P(CutShortly, AStepIsUndone) {
  constexpr uint64_t kScenes = 30;
  constexpr int kStepsOfScene = 40;
  size_t cut = 0, before_a_solve = 0;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const RandomScene free = MakeRandomScene({GetParam()}, seed), bound = MakeRandomScene({GetParam()}, seed);
    World& world = *bound.world;
    Random random(seed ^ 0xc07);
    bool is_twin = true;
    for (int step = 0; step < kStepsOfScene; ++step) {
      world.TakeEvents();
      const uint64_t hash = world.StateHash();
      const std::string all_but_engine = AllButTheEngineOf(world);
      int asked = 0;
      const int last = 1 + static_cast<int>(random.Below(random.Chance(0.5) ? 10 : 500));
      Status status;
      {
        const WorkWatch watch(EnoughAt(asked, last), 1);
        status = world.Step();
      }
      if (!status.ok()) {
        ++cut;
        ASSERT_EQ(status.code(), absl::StatusCode::kCancelled) << status;
        ASSERT_TRUE(AllButTheEngineOf(world) == all_but_engine) << "step " << step << " at " << last;
        ASSERT_TRUE(world.TakeEvents().empty());
        ASSERT_FALSE(world.faulted());
        if (MessageOf(status).find("the engine began anew") == std::string::npos) {
          ++before_a_solve;
          ASSERT_EQ(world.StateHash(), hash) << "step " << step << " at " << last;
        } else {
          is_twin = false;
        }
        Steps(world, 1);
      }
      Steps(*free.world, 1);
      if (is_twin) {
        ASSERT_EQ(world.StateHash(), free.world->StateHash()) << "step " << step;
      }
    }
    ASSERT_TRUE(world.state().positions.allFinite() && world.state().linear_velocities.allFinite());
  }
  EXPECT_GT(cut, kScenes * kStepsOfScene / 4);
  EXPECT_GT(before_a_solve, kScenes / 2);
}

TEST_P(CutShortly, AStepThatLooksAtTooMuchIsOverItsBudget) {
  const auto world = MakeWorld();
  Require(*world, Feature::kShapeConvexHull);
  for (int i = 0; i < 8; ++i) Add(*world, Body(HullBox({0.5, 0.5, 0.5}), {0.1 * i, 0, 5}));
  const uint64_t before = world->StateHash();
  world->set_budget({.looks = 1000});
  for (int i = 0; i < 2; ++i) {
    int asked = 0;
    const WorkWatch watch(EnoughAt(asked, 1'000'000), 1);
    const Status status = world->Step();
    EXPECT_EQ(RefusalOf(status).value_or(Refusal{}).reason, Reason::kBudgetExceeded) << status;
    EXPECT_EQ(world->StateHash(), before);
  }
  world->set_budget({});
  Steps(*world, 3);
}

TEST_P(CutShortly, WhatIsAskedOfAWorldEndsWithinAShape) {
  const auto world = MakeWorld();
  Require(*world, Feature::kShapeQueries);
  Add(*world, Still(Sphere{0.5}, {0, 0, 5}));
  int asked = 0;
  const WorkWatch watch(EnoughAt(asked, 3), 1);
  const std::vector<Pose> poses(10, Pose{.position = {0, 0, 5.5}});
  EXPECT_THROW(static_cast<void>(world->FindOverlaps(Sphere{0.5}, poses)), CutShort);
}

}  // namespace
}  // namespace genphys::testing

// The solver that is asked for is the one that solves, on every engine.
#include <cmath>

#include "engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Solvers, Claim::kSolverDirect);

constexpr double kGravity = 9.81;

std::unique_ptr<World> Solved(const std::string& engine, Solver solver) {
  return MakeWorld(WorldDesc{.engine = engine,
                             .gravity = {0, 0, -kGravity},
                             .stepper = {.solver = solver},
                             .default_auto_disable = {.enabled = false},
                             .recorded_events = {.persisting_contacts = true}});
}

TEST_P(Solvers, ADirectOneCarriesAStackToARounding) {
  constexpr int kCrates = 5;
  const auto world = Solved(GetParam(), Solver::kDirect);
  std::vector<EntityId> ids;
  for (int i = 0; i < kCrates; ++i) ids.push_back(Add(*world, Crate({0, 0, 0.5 + i})));
  Steps(*world, 120);
  world->TakeEvents();

  Steps(*world, 60);

  std::vector<double> carried(ids.size() + 1);
  for (const ContactPersisted& contact : Of<ContactPersisted>(world->TakeEvents())) {
    for (const EventContactPoint& point : contact.points)
      carried[contact.pair.b.index() - ids[0].index()] += point.normal_impulse;
  }
  for (int i = 0; i < kCrates; ++i) {
    EXPECT_NEAR(carried[static_cast<size_t>(i)] / ((kCrates - i) * kGravity), 1, kDirect) << i;
  }
}

TEST_P(Solvers, ADirectOneLetsALightCrateCarryAHeavyOne) {
  constexpr double kRatio = 1e4;
  const auto world = Solved(GetParam(), Solver::kDirect);
  const EntityId light = Add(*world, Crate({0, 0, 0.5})), heavy = Add(*world, Crate({0, 0, 1.5}, 0.5, kRatio));

  Steps(*world, 120);

  EXPECT_NEAR(PositionOf(*world, light).z(), 0.5, kTouch);
  EXPECT_NEAR(PositionOf(*world, heavy).z(), 1.5, 2 * kTouch);
}

TEST_P(Solvers, ADirectOneSlidesAndHoldsAsCoulombSays) {
  constexpr double kFriction = 0.5;
  for (const double slope : {0.9, 1.1}) {
    const auto world = Solved(GetParam(), Solver::kDirect);
    Do(*world, SetGravity{{slope * kFriction * kGravity, 0, -kGravity}});
    const EntityId crate = Add(*world, Body(Box{{0.3, 0.2, 0.1}}, {0, 0, 0.1}));

    Steps(*world, 60);

    const double acceleration = slope > 1 ? (slope - 1) * kFriction * kGravity : 0;
    EXPECT_NEAR(VelocityOf(*world, crate).x(), acceleration, kDirect * slope * kFriction * kGravity) << slope;
  }
}

TEST_P(Solvers, WhatIsTooLargeToBeSolvedAtOnceIsSolvedInSweeps) {
  const auto world = Solved(GetParam(), Solver::kDirect);
  std::vector<EntityId> ids;
  // More than a hundred contact points in one island.
  for (int i = 0; i < 60; ++i) ids.push_back(Add(*world, Crate({0.99 * (i % 6), 0.99 * (i / 6), 0.5})));

  Steps(*world, 60);

  for (const EntityId id : ids) EXPECT_NEAR(PositionOf(*world, id).z(), 0.5, kTouch);
}

TEST_P(Solvers, ChangeBetweenAnyTwoSteps) {
  const auto world = Solved(GetParam(), Solver::kAutomatic);
  std::vector<EntityId> ids;
  for (int i = 0; i < 3; ++i) ids.push_back(Add(*world, Crate({0, 0, 0.5 + i})));
  for (int i = 0; i < 120; ++i) {
    const Solver solver = i % 3 == 0 ? Solver::kDirect : i % 3 == 1 ? Solver::kIterative : Solver::kAutomatic;
    Do(*world, SetStepper{{.solver = solver}});
    Steps(*world, 1);
  }

  for (size_t i = 0; i < ids.size(); ++i) {
    EXPECT_LE((PositionOf(*world, ids[i]) - Vector3(0, 0, 0.5 + static_cast<double>(i))).norm(),
              static_cast<double>(i + 1) * kTouch);
  }
}

}  // namespace
}  // namespace genphys::testing

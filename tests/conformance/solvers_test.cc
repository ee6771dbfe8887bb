// The solver that is asked for is the one that solves, on every engine.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine_test.h"
#include "support/joints.h"

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

// Sweeps would let what is heavy fall through what is light, or shake it off: nobody has to ask for a solver.
TEST_P(Solvers, WhatIsLightCarriesWhatIsHeavyUnasked) {
  constexpr double kTime = 5;
  constexpr double kSink = 1e-3;  // m, the bar of S2 for ten thousand to one
  const auto plate = [](double x, double z) { return Body(Box{{1.5, 0.5, 0.1}}, {x, 0, z}); };
  const auto crate = [](double x, double z, double mass) { return Crate({x, 0, z}, 0.5, mass); };
  for (const double heavy : {100.0, 1e3, 1e4}) {
    const std::vector<std::vector<EntityDesc>> piles{
        {crate(0, 0.5, 1), crate(0, 1.5, heavy)},
        {crate(0, 0.5, 1), crate(0, 1.5, 1), crate(0, 2.5, 1), crate(0, 3.5, heavy)},
        {plate(0, 0.1), crate(-0.7, 0.7, heavy), crate(0.7, 0.7, 0.4 * heavy)},
    };
    for (const std::vector<EntityDesc>& pile : piles) {
      SCOPED_TRACE(::testing::Message() << pile.size() << " of up to " << heavy << " kg");
      const auto world = Solved(GetParam(), Solver::kAutomatic);
      std::vector<EntityId> ids;
      for (const EntityDesc& body : pile) ids.push_back(Add(*world, body));
      Steps(*world, static_cast<int>(kTime * 60));
      for (size_t i = 0; i < pile.size(); ++i) {
        const Vector3 off = PositionOf(*world, ids[i]) - pile[i].pose.position;
        // Each contact below it may be as deep as what touches.
        EXPECT_NEAR(off.norm(), 0, heavy > 1e3 ? kSink : kTouch * static_cast<double>(i + 1)) << i;
      }
    }
  }
}

// Of so even a ring of points an exact solver may find no way on, in one step of many.
TEST_P(Solvers, ALightDrumCarriesAHeavyOneUnasked) {
  constexpr double kRadius = 0.0675, kHalf = 0.075, kMass = 2.1;
  for (const double tilt : {0.0, 1e-4, 1e-3, 1e-2}) {
    const auto world = Solved(GetParam(), Solver::kAutomatic);
    EntityDesc light = Body(Cylinder{kHalf, kHalf}, {0, 0, kHalf}, kMass);
    light.pose.orientation = Eigen::AngleAxisd(tilt, Vector3::UnitY());
    const EntityId lower = Add(*world, light);
    const Vector3 place(1e-6, 2e-6, 3 * kHalf);
    const EntityId upper = Add(*world, Body(Cylinder{kRadius, kHalf}, place, 100 * kMass));
    Steps(*world, 120);
    // It rights itself about a point of its rim, or of its top.
    const double righted = 2 * tilt * kHalf;
    EXPECT_NEAR((PositionOf(*world, upper) - place).norm(), 0, 2 * kTouch + righted) << tilt;
    EXPECT_NEAR((PositionOf(*world, lower) - Vector3(0, 0, kHalf)).norm(), 0, kTouch + righted) << tilt;
  }
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

/// Plates in rows on a heavy slab that nothing but its weight holds where it is.
struct Crowd {
  std::unique_ptr<World> world;
  std::vector<EntityId> plates;
  std::vector<Vector3> starts;
};

constexpr double kPlateFriction = 0.5;

Crowd PlatesOnASlab(const std::string& engine, int count, const Vector3& velocity) {
  const Material rough{.friction = 2};
  Crowd crowd{.world = MakeWorld(WorldDesc{.engine = engine,
                                           .gravity = {0, 0, -kGravity},
                                           .default_material = rough,
                                           .default_auto_disable = {.enabled = false}})};
  Add(*crowd.world, Body(Box{{8, 8, 0.5}}, {0, 0, 0.5}, 1e4));
  for (int i = 0; i < count; ++i) {
    crowd.starts.emplace_back(i % 10 - 4.5, i / 10 - 5.0, 1.1);
    EntityDesc plate = Body(Box{{0.3, 0.2, 0.1}}, crowd.starts.back());
    plate.rigid_body->geometries[0].material = {.friction = kPlateFriction, .friction_mixing = Mixing::kMinimum};
    plate.rigid_body->linear_velocity = velocity;
    crowd.plates.push_back(Add(*crowd.world, plate));
  }
  return crowd;
}

/// One plate, and so many that they are an island of more than four hundred contacts; slides along the sides of plates
/// and across them.
struct Slide {
  int count = 0;
  Vector3 along = Vector3::UnitX();
};

std::vector<Slide> Slides() {
  std::vector<Slide> slides;
  for (const int count : {1, 110}) {
    for (const double degrees : {0, 30, 45}) {
      const double heading = degrees * std::numbers::pi / 180;
      slides.push_back({count, {std::cos(heading), std::sin(heading), 0}});
    }
  }
  return slides;
}

// Plate and slab fall together, so that nothing slips before a solve that would tell where the plate wants to.
TEST_P(Solvers, SweepsHoldAndSlideOnWhatCanMoveAsCoulombSays) {
  Proves({Claim::kKineticFriction});
  for (const auto& [count, along] : Slides()) {
    for (const double slope : {0.1, 0.5, 0.7, 0.9, 1.05}) {
      Crowd crowd = PlatesOnASlab(GetParam(), count, Vector3::Zero());
      Do(*crowd.world, SetGravity{slope * kPlateFriction * kGravity * along - Vector3(0, 0, kGravity)});

      Steps(*crowd.world, 60);

      // What slides begins to in one of the first few steps. What holds stands still; held by what it has no direction
      // for it keeps 1e-2 and more.
      const double slides = std::max(slope - 1, 0.0) * kPlateFriction * kGravity;
      const double tolerance = slope > 1 ? 0.2 * slides : 1e-6;
      for (const EntityId id : crowd.plates) {
        EXPECT_LE((VelocityOf(*crowd.world, id) - slides * along).norm(), tolerance) << slope << " " << along;
      }
    }
  }
}

TEST_P(Solvers, SweepsStopASlideOnWhatCanMoveWhereCoulombSays) {
  Proves({Claim::kKineticFriction});
  constexpr double kSpeed = 2;
  for (const auto& [count, along] : Slides()) {
    Crowd crowd = PlatesOnASlab(GetParam(), count, kSpeed * along);

    Steps(*crowd.world, 120);

    const double way = kSpeed * kSpeed / (2 * kPlateFriction * kGravity);
    for (size_t i = 0; i < crowd.plates.size(); ++i) {
      const Vector3 end = PositionOf(*crowd.world, crowd.plates[i]);
      EXPECT_LE((end - crowd.starts[i] - way * along).norm(), 1e-4 * way) << count << " " << along;
    }
  }
}

// Crates on the floor, each of them on a ball joint to the next one; the last one weighs more.
struct Train {
  Quality quality = Quality::kBalanced;
  int count = 0;
  double last = 1;  // kg
};

// Where they are after the first was drawn aside.
std::vector<Vector3> Dragged(const std::string& engine, const Train& train, Solver solver) {
  const auto world = MakeWorld(WorldDesc{.engine = engine,
                                         .gravity = {0, 0, -kGravity},
                                         .stepper = {.quality = train.quality, .solver = solver},
                                         .default_auto_disable = {.enabled = false}});
  std::vector<EntityId> ids;
  for (int i = 0; i < train.count; ++i) {
    EntityDesc crate = Crate({1.5 * i, 0, 0.5}, 0.5, i + 1 < train.count ? 1 : train.last);
    if (i == 0) crate.rigid_body->linear_velocity.y() = 1;
    ids.push_back(Add(*world, crate));
    const Pose middle{.position = {0.75, 0, 0}};
    if (i > 0) Join(*world, Between(ids[ids.size() - 2], ids.back(), BallJoint{}, middle));
  }
  Steps(*world, 5);
  std::vector<Vector3> places;
  for (const EntityId id : ids) places.push_back(PositionOf(*world, id));
  return places;
}

// Twelve rows of each crate on the floor, and three of each joint.
TEST_P(Solvers, LargeIslandsOfJointsOnAFloorAreSweptWhereAPresetHasNoMoreTimeForThem) {
  const auto is_swept = [](const Train& train) {
    return Dragged(GetParam(), train, Solver::kAutomatic) == Dragged(GetParam(), train, Solver::kIterative);
  };
  EXPECT_FALSE(is_swept({Quality::kFast, 4})) << "57 rows";
  EXPECT_TRUE(is_swept({Quality::kFast, 5})) << "72 rows";
  for (const Quality quality : {Quality::kBalanced, Quality::kAccurate}) {
    EXPECT_FALSE(is_swept({quality, 10})) << "147 rows";
    EXPECT_TRUE(is_swept({quality, 11})) << "162 rows";
  }
}

TEST_P(Solvers, FastSweepsNoIslandOfJointsInWhichSomethingIsVeryHeavy) {
  const auto is_swept = [](const Train& train) {
    return Dragged(GetParam(), train, Solver::kAutomatic) == Dragged(GetParam(), train, Solver::kIterative);
  };
  EXPECT_TRUE(is_swept({Quality::kFast, 10, 49}));
  EXPECT_FALSE(is_swept({Quality::kFast, 10, 51}));
  EXPECT_TRUE(is_swept({Quality::kFast, 11, 51})) << "162 rows";
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

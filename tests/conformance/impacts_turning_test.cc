// What turns fast may pass through something thin between two substeps. Known are Newton's law and what it keeps.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfTurning, Claim::kContacts, Claim::kRestitution, Claim::kBox);

constexpr double kStep = 1.0 / 60;
constexpr double kRadius = 0.03;     // of the ball
constexpr double kThickness = 0.01;  // half of it, of the blade
constexpr double kBallMass = 0.2;
// Of the blade of 1 kg about its middle, kg*m^2.
constexpr double kInertia = (1 + kThickness * kThickness) / 3;

EntityDesc Elastic(EntityDesc desc) {
  desc.rigid_body->geometries[0].material.restitution = 1;
  desc.rigid_body->geometries[0].material.friction = 0;
  return desc;
}

// Two metres long, about the origin, turned by `angle` about z.
EntityDesc Blade(double angle, double spin) {
  EntityDesc blade = Elastic(Body(Box{{1, kThickness, kThickness}}, Vector3::Zero()));
  blade.pose.orientation = Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitZ()));
  blade.rigid_body->angular_velocity = {0, 0, spin};
  return blade;
}

// A blade comes upon a ball at rest.
struct Stroke {
  double spin;   // rad/s
  double ahead;  // rad, from the blade to the ball
  double arm;    // m, from the middle of the blade to where it hits
  Vector3 ball;
};

Stroke RandomStroke(Random& random) {
  const double spin = random.LogUniform(3, 100), ahead = random.Uniform(0.3, 1.2), distance = random.Uniform(0.3, 0.9);
  return {spin, ahead, std::sqrt(distance * distance - std::pow(kRadius + kThickness, 2)),
          distance * Vector3(std::cos(ahead), std::sin(ahead), 0)};
}

int StepsOf(const Stroke& stroke) { return static_cast<int>(stroke.ahead / stroke.spin / kStep) + 1; }

TEST_P(ImpactsOfTurning, MissNothingThatAFreeBladeComesUpon) {
  Proves({Claim::kSphere});
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stroke stroke = RandomStroke(random);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    Add(*world, Blade(0, stroke.spin));
    const EntityId ball = Add(*world, Elastic(Ball(stroke.ball, kRadius, kBallMass)));
    const double before = KineticEnergyOf(*world);
    Steps(*world, StepsOf(stroke));
    const double share = stroke.arm * stroke.arm / kInertia + 1 + 1 / kBallMass;
    const double speed = 2 * stroke.spin * stroke.arm / (kBallMass * share);
    EXPECT_NEAR(VelocityOf(*world, ball).norm(), speed, 1e-5 * speed);
    EXPECT_NEAR(KineticEnergyOf(*world), before, 1e-12 * before);
  }
}

TEST_P(ImpactsOfTurning, MissNothingThatABladeOnAHingeComesUpon) {
  Proves({Claim::kSphere, Claim::kJointHinge});
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stroke stroke = RandomStroke(random);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    const EntityId blade = Add(*world, Blade(0, stroke.spin));
    Join(*world, ToWorld(blade, HingeJoint{}, FrameAlong(Vector3::UnitZ())));
    const EntityId ball = Add(*world, Elastic(Ball(stroke.ball, kRadius, kBallMass)));
    Steps(*world, StepsOf(stroke));
    const double share = stroke.arm * stroke.arm / kInertia + 1 / kBallMass;
    const double speed = 2 * stroke.spin * stroke.arm / (kBallMass * share);
    EXPECT_NEAR(VelocityOf(*world, ball).norm(), speed, 1e-5 * speed);
  }
}

TEST_P(ImpactsOfTurning, MissNothingThatABladeOnItsGivenWayComesUpon) {
  Proves({Claim::kSphere, Claim::kKinematicPush});
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Stroke stroke = RandomStroke(random);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    EntityDesc blade = Blade(0, stroke.spin);
    blade.rigid_body->motion_type = MotionType::kKinematic;
    Add(*world, blade);
    const EntityId ball = Add(*world, Elastic(Ball(stroke.ball, kRadius, kBallMass)));
    Steps(*world, StepsOf(stroke));
    const double speed = 2 * stroke.spin * stroke.arm;
    EXPECT_NEAR(VelocityOf(*world, ball).norm(), speed, 1e-5 * speed);
  }
}

// Side by side at first, they turn against each other.
TEST_P(ImpactsOfTurning, KeepTheEnergyOfBladesThatCross) {
  int hits = 0;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    const double spin = random.LogUniform(5, 60);
    const EntityId a = Add(*world, Blade(0, spin));
    EntityDesc other = Blade(random.Uniform(-0.2, 0.2), -random.LogUniform(5, 60));
    other.pose.position = {random.Uniform(-0.5, 0.5), random.Uniform(0.5, 1.5), 0};
    Add(*world, other);
    const double before = KineticEnergyOf(*world);
    Steps(*world, 30);
    hits += std::abs(SpinOf(*world, a).z() - spin) > 1e-6;
    EXPECT_NEAR(KineticEnergyOf(*world), before, 1e-9 * before);
  }
  EXPECT_GT(hits, 40);
}

// However it is turned, towards +x at a wall about the origin.
struct Throw {
  const Shape& shape;
  double speed;        // m/s
  double restitution;  // of both
  double wall;         // m, half of its thickness
};

bool IsStopped(const std::string& engine, const StepperDesc& stepper, const Throw& thrown, Random& random) {
  const auto world = MakeSpace(engine, stepper, Vector3::Zero());
  EntityDesc wall = Block(Vector3::Zero(), {thrown.wall, 5, 5});
  EntityDesc body = Body(thrown.shape, {-0.3 - random.Uniform(0, 1), 0, 0});
  body.pose.orientation = random.Turn();
  body.rigid_body->linear_velocity = {thrown.speed, 0, 0};
  for (EntityDesc* each : {&wall, &body}) each->rigid_body->geometries[0].material.restitution = thrown.restitution;
  Add(*world, wall);
  const EntityId id = Add(*world, body);
  for (int steps = 0; steps < 2 / thrown.speed / stepper.step_size; ++steps) Steps(*world, 1);
  return PositionOf(*world, id).x() < 0;
}

// A blow out of its middle sets it spinning by hundreds of radians a second, and the next part of it comes on within
// the same substep.
TEST_P(ImpactsOfTurning, LetNothingRollThroughAThinWall) {
  Proves({Claim::kCapsule, Claim::kCylinder, Claim::kEllipsoid, Claim::kConvexHull});
  const Vector3 halves(0.05, 0.03, 0.04);
  const std::vector<Shape> shapes{Box{halves}, Capsule{0.03, 0.05}, Cylinder{0.04, 0.04}, Ellipsoid{{0.05, 0.03, 0.02}},
                                  HullBox(halves)};
  const StepperDesc stepper{.step_size = kStep / 2, .quality = Quality::kFast};
  for (uint64_t seed = 1; seed <= 1500; ++seed) {
    Random random(seed);
    const double speed = random.LogUniform(20, 60), restitution = seed % 4 == 0 ? random.Uniform(0, 1) : 0;
    const Throw thrown{shapes[seed % shapes.size()], speed, restitution, 0.01};
    EXPECT_TRUE(IsStopped(GetParam(), stepper, thrown, random)) << "seed " << seed << ", " << speed << " m/s";
  }
}

// One end touches the wall, and the far one falls on it before it has turned by much: in one substep it goes farther
// than it is thick.
TEST_P(ImpactsOfTurning, LetNoFarEndThroughAThinWall) {
  Proves({Claim::kCapsule, Claim::kCylinder, Claim::kEllipsoid});
  const std::vector<Shape> shapes{Box{{0.1, 0.002, 0.002}}, Box{{0.1, 0.1, 0.003}}, Capsule{0.005, 0.095},
                                  Cylinder{0.005, 0.1}, Ellipsoid{{0.1, 0.005, 0.005}}};
  for (uint64_t seed = 1; seed <= 500; ++seed) {
    Random random(seed);
    const double speed = random.LogUniform(3, 100), restitution = seed % 4 == 0 ? random.Uniform(0, 1) : 0;
    const Throw thrown{shapes[seed % shapes.size()], speed, restitution, 0.002};
    EXPECT_TRUE(IsStopped(GetParam(), {.step_size = kStep}, thrown, random))
        << "seed " << seed << ", " << speed << " m/s";
  }
}

// All around sweeps over what lies beneath, and touches nothing.
TEST_P(ImpactsOfTurning, LeaveAloneWhatTurnsCloselyAboveAFloor) {
  const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
  EntityDesc floor = Elastic(Block({0, 0, -0.5 - 1e-4}, {3, 3, 0.5}));
  Add(*world, floor);
  EntityDesc blade = Blade(0, 100);
  blade.pose.position.z() = kThickness;
  const EntityId id = Add(*world, blade);
  Steps(*world, 60);
  EXPECT_EQ(SpinOf(*world, id), Vector3(0, 0, 100));
  EXPECT_EQ(VelocityOf(*world, id), Vector3::Zero());
}

// Seconds that a step takes, at least, of two blades of 10 m that turn 1 m above as many crates.
double StepAbove(const std::string& engine, int crates, MotionType motion_type) {
  constexpr int kRow = 30, kTrials = 30;
  constexpr double kSpacing = 1;  // m
  const auto world = MakeSpace(engine, {.step_size = kStep}, Vector3::Zero());
  for (int i = 0; i < crates; ++i) {
    const Vector3 place(i % kRow - kRow / 2, i / kRow - kRow / 2, -1);
    Add(*world, Block(kSpacing * place, {0.4, 0.4, 0.4}));
  }
  for (const double side : {-1.0, 1.0}) {
    EntityDesc blade = Body(Box{{5, kThickness, kThickness}}, {6 * side, 0, 0.4});
    blade.rigid_body->motion_type = motion_type;
    blade.rigid_body->angular_velocity = {0, 0, 3 * side};
    Add(*world, blade);
  }
  Steps(*world, 3);
  double least = std::numeric_limits<double>::infinity();
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto start = std::chrono::steady_clock::now();
    Steps(*world, 1);
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

// To look along the ways of all points of a blade takes a hundred times as long as to see that it goes past something.
TEST_P(ImpactsOfTurning, CostLittleMoreAboveWhatTheyDoNotMeet) {
  for (const MotionType motion_type : {MotionType::kDynamic, MotionType::kKinematic}) {
    EXPECT_LE(StepAbove(GetParam(), 900, motion_type), 15 * StepAbove(GetParam(), 0, motion_type));
  }
}

}  // namespace
}  // namespace genphys::testing

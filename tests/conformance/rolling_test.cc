// What resists rolling and spinning: a torque of at most coefficient times normal force, on every engine.
#include <cmath>
#include <limits>
#include <vector>

#include "engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Rolling, Claim::kRollingFriction);

constexpr double kGravity = 9.81, kRadius = 0.5, kStep = 1.0 / 60;
// Of a solid ball, moment over m r^2, and what a push at its centre moves beside a ball that need not turn.
constexpr double kMoment = 0.4;
constexpr double kRolls = 1 / (1 + kMoment);

std::unique_ptr<World> OnFloor(const std::string& engine, const Material& all, Solver solver = Solver::kAutomatic) {
  return MakeWorld(WorldDesc{.engine = engine,
                             .gravity = {0, 0, -kGravity},
                             .stepper = {.step_size = kStep, .solver = solver},
                             .default_material = all,
                             .default_auto_disable = {.enabled = false}});
}

/// A ball that rolls over the floor without sliding.
EntityDesc RollingBall(const Vector3& velocity) {
  EntityDesc ball = Ball({0, 0, kRadius}, kRadius, 3);
  ball.rigid_body->linear_velocity = velocity;
  ball.rigid_body->angular_velocity = Vector3::UnitZ().cross(velocity) / kRadius;
  return ball;
}

TEST_P(Rolling, ABallStopsWhereTheClosedFormSaysWhateverItsHeading) {
  constexpr double kSpeed = 2, kArm = 0.04;
  // m v' = -f and I w' = f r - arm N, with v = w r.
  const double braking = kRolls * kArm / kRadius * kGravity;
  const double distance = kSpeed * kSpeed / (2 * braking);
  for (const double heading : {0.0, 0.5, M_PI / 4, 2.2}) {
    const auto world = OnFloor(GetParam(), {.rolling_friction = kArm});
    const Vector3 along(std::cos(heading), std::sin(heading), 0);
    const EntityId ball = Add(*world, RollingBall(kSpeed * along));

    Steps(*world, static_cast<int>(1.2 * kSpeed / braking / kStep));

    const Vector3 way = PositionOf(*world, ball) - Vector3(0, 0, kRadius);
    // What brakes may act a solve late, in which the ball goes on; and along the spin of the solve before, so that as
    // much may be lacking across.
    const double tolerance = 2 * kSpeed * SubstepOf(*world);
    EXPECT_NEAR(way.dot(along), distance, tolerance) << heading;
    EXPECT_NEAR(way.cross(along).norm(), 0, tolerance) << heading;
    EXPECT_LE(VelocityOf(*world, ball).norm(), SweptSpeed(kGravity, SubstepOf(*world))) << "it lies still";
  }
}

// In each step, for it rolls all the time.
TEST_P(Rolling, ABallIsBrakedEvenly) {
  constexpr double kSpeed = 1, kArm = 0.05;
  const double braking = kRolls * kArm / kRadius * kGravity;
  for (const bool is_on_slab : {false, true}) {
    for (const double heading : is_on_slab ? std::vector{0.0} : std::vector{0.0, 0.8}) {
      const auto world = OnFloor(GetParam(), {.friction = 2, .rolling_friction = kArm});
      const Vector3 along(std::cos(heading), std::sin(heading), 0);
      EntityDesc rolling = RollingBall(kSpeed * along);
      if (is_on_slab) {
        Proves({Claim::kBox});
        Add(*world, Body(Box{{2, 2, 0.1}}, {0, 0, 0.1}, 20));
        rolling.pose.position.z() += 0.2;
      }
      const EntityId ball = Add(*world, rolling);
      // A slab gives way a little.
      const double tolerance = is_on_slab ? 1e-3 : 1e-6;
      for (int step = 1; step <= 60; ++step) {
        Steps(*world, 1);
        const double exact = kSpeed - braking * step * kStep;
        ASSERT_NEAR(VelocityOf(*world, ball).dot(along), exact, tolerance) << heading << " " << step;
        ASSERT_NEAR(SpinOf(*world, ball).norm() * kRadius, exact, tolerance) << heading << " " << step;
      }
    }
  }
}

TEST_P(Rolling, ABallLiesStillOnASlopeUpToItsArmAndRollsDownBeyondWhateverWayThatIs) {
  constexpr double kArm = 0.05, kSeconds = 2;
  constexpr double kSteepest = kArm / kRadius;
  for (const double slope : {0.9 * kSteepest, 1.1 * kSteepest}) {
    for (const double heading : {0.0, 0.4, M_PI / 4, 2.2}) {
      const Vector3 down(std::cos(heading), std::sin(heading), 0);
      const auto world = OnFloor(GetParam(), {.rolling_friction = kArm});
      Do(*world, SetGravity{slope * kGravity * down - kGravity * Vector3::UnitZ()});
      const EntityId ball = Add(*world, RollingBall(Vector3::Zero()));

      Steps(*world, static_cast<int>(kSeconds / kStep));

      const double acceleration = slope > kSteepest ? kRolls * (slope - kSteepest) * kGravity : 0;
      // The first step meets no weight yet that the ball rests with, and the method adds a h t / 2.
      const double tolerance = 2 * (acceleration * kStep * kSeconds / 2 + slope * kGravity * kStep * kStep);
      const Vector3 way = PositionOf(*world, ball) - Vector3(0, 0, kRadius);
      EXPECT_NEAR(way.dot(down), acceleration * kSeconds * kSeconds / 2, tolerance) << slope << " " << heading;
      EXPECT_NEAR(way.cross(down).norm(), 0, tolerance) << slope << " " << heading;
    }
  }
}

// Each side holds it as the other one does, whatever slips there before a solve.
TEST_P(Rolling, ABallInAGrooveRollsOnBothItsSides) {
  Proves({Claim::kBox});
  constexpr double kPull = 2, kTime = 1;  // m/s^2 along the groove, s
  const Vector3 above_floor(0, 0, 4);
  for (const double friction : {0.5, 0.9}) {
    const auto world = testing::MakeWorld(WorldDesc{.engine = GetParam(),
                                                    .gravity = {kPull, 0, -kGravity},
                                                    .stepper = {.step_size = kStep},
                                                    .default_material = {.friction = friction},
                                                    .default_auto_disable = {.enabled = false}});
    for (const int side : {-1, 1}) {
      EntityDesc wall = Block({}, {20, 2, 0.5});
      wall.pose.orientation = Eigen::AngleAxisd(side * M_PI / 4, Vector3::UnitX());
      wall.pose.position = wall.pose.orientation * Vector3(0, 1.5 * side, -0.5) + above_floor;
      Add(*world, wall);
    }
    const EntityId ball = Add(*world, Ball(kRadius * M_SQRT2 * Vector3::UnitZ() + above_floor, kRadius, 3));
    Steps(*world, static_cast<int>(kTime / kStep));

    // It turns about the line between its points, which is that much nearer to its middle.
    const double arm = kRadius / M_SQRT2, gained = kPull / (1 + kMoment * kRadius * kRadius / (arm * arm));
    EXPECT_NEAR(PositionOf(*world, ball).x(), gained * kTime * kTime / 2, kRounded) << friction;
    EXPECT_NEAR(VelocityOf(*world, ball).x(), gained * kTime, kRounded) << friction;
    EXPECT_NEAR(SpinOf(*world, ball).y() * arm, gained * kTime, kRounded) << friction;
  }
}

TEST_P(Rolling, ASpinIsBrakedBySpinningFrictionAndNotByRollingFriction) {
  constexpr double kSpin = 10, kArm = 0.01;
  const auto world = OnFloor(GetParam(), {.spinning_friction = kArm});
  const auto other = OnFloor(GetParam(), {.rolling_friction = kArm});
  EntityDesc top = RollingBall(Vector3::Zero());
  top.rigid_body->angular_velocity = {0, 0, kSpin};
  const EntityId braked = Add(*world, top), free = Add(*other, top);
  const double braking = kArm * kGravity / (kMoment * kRadius * kRadius);

  for (World* each : {world.get(), other.get()}) Steps(*each, 120);

  EXPECT_NEAR(SpinOf(*world, braked).z(), kSpin - 2 * braking, 2 * kSwept * 2 * braking);
  EXPECT_NEAR(SpinOf(*other, free).z(), kSpin, kRounded * kSpin);
  Steps(*world, static_cast<int>(kSpin / braking / kStep));
  EXPECT_NEAR(SpinOf(*world, braked).norm(), 0, kSwept * braking * kStep) << "it stops and does not turn back";
}

TEST_P(Rolling, ATurntableTakesAlongWhatStandsOnIt) {
  constexpr double kTurn = 3, kArm = 0.02;
  const auto world = OnFloor(GetParam(), {.spinning_friction = kArm});
  EntityDesc table = Block({0, 0, 1}, {1, 1, 0.1});
  table.rigid_body->motion_type = MotionType::kKinematic;
  table.rigid_body->angular_velocity = {0, 0, kTurn};
  Add(*world, table);
  EntityDesc ball = RollingBall(Vector3::Zero());
  ball.pose.position.z() += 1.1;
  const EntityId id = Add(*world, ball);
  const double turning = kArm * kGravity / (kMoment * kRadius * kRadius);

  Steps(*world, 30);
  EXPECT_NEAR(SpinOf(*world, id).z(), turning / 2, 2 * kSwept * turning / 2);
  Steps(*world, 90);
  EXPECT_NEAR(SpinOf(*world, id).z(), kTurn, kSwept * turning * kStep) << "and then turns with it";
}

TEST_P(Rolling, TheCoefficientsMixAsFrictionDoes) {
  constexpr double kSpeed = 2, kArm = 0.04;
  for (const auto& [rule, arm] : {std::pair{Mixing::kGeometricMean, 0.0},
                                  {Mixing::kAverage, kArm / 2},
                                  {Mixing::kMinimum, 0.0},
                                  {Mixing::kMaximum, kArm}}) {
    const auto world = OnFloor(GetParam(), {});
    EntityDesc ball = RollingBall({kSpeed, 0, 0});
    ball.rigid_body->geometries[0].material = {.friction_mixing = rule, .rolling_friction = kArm};
    const EntityId id = Add(*world, ball);

    Steps(*world, 60);

    const double braking = kRolls * arm / kRadius * kGravity;
    // One step more or less of the strongest braking.
    constexpr double kTolerance = 2 * kRolls * kArm / kRadius * kGravity * kStep;
    EXPECT_NEAR(VelocityOf(*world, id).x(), kSpeed - braking, kTolerance) << static_cast<int>(rule);
  }
}

TEST_P(Rolling, IsTheSameWhateverTheSolver) {
  constexpr double kSpeed = 2, kArm = 0.04;
  const double braking = kRolls * kArm / kRadius * kGravity;
  for (const Solver solver : {Solver::kIterative, Solver::kDirect}) {
    const auto world = OnFloor(GetParam(), {.rolling_friction = kArm, .spinning_friction = kArm}, solver);
    const EntityId ball = Add(*world, RollingBall({kSpeed, 0, 0}));
    // Many points of one side, all of which resist.
    const EntityId crate = Add(*world, Crate({0, 5, 0.5}));

    Steps(*world, 60);

    EXPECT_NEAR(VelocityOf(*world, ball).x(), kSpeed - braking, 2 * braking * kStep);
    EXPECT_LE((PositionOf(*world, crate) - Vector3(0, 5, 0.5)).norm(), kTouch);
  }
}

TEST_P(Rolling, HardlyResistedIsAsIfItWereNot) {
  for (const double arm : {1e-20, 1e-160, 1e-250, std::numeric_limits<double>::denorm_min()}) {
    const auto world = OnFloor(GetParam(), {.rolling_friction = arm, .spinning_friction = arm});
    const EntityId ball = Add(*world, RollingBall({2, 0, 0}));
    const EntityId crate = Add(*world, Crate({0, 5, 1.2}));

    Steps(*world, 60);

    EXPECT_NEAR(VelocityOf(*world, ball).x(), 2, 1e-3) << arm;
    EXPECT_NEAR(PositionOf(*world, crate).z(), 0.5, 0.01) << arm;
  }
}

TEST_P(Rolling, GoesOnAlikeOnAnotherEngine) {
  constexpr double kSpeed = 2, kArm = 0.04;
  const double braking = kRolls * kArm / kRadius * kGravity;
  const auto world = OnFloor(GetParam(), {.rolling_friction = kArm});
  const EntityId ball = Add(*world, RollingBall({kSpeed, 0, 0}));
  for (const std::string& engine : {GetParam(), OtherEngine(GetParam()), GetParam()}) {
    Do(*world, SetEngine{engine});
    Steps(*world, 30);
  }
  constexpr double seconds = 1.5;

  // On each engine it may begin a solve late.
  EXPECT_NEAR(VelocityOf(*world, ball).x(), kSpeed - braking * seconds, 3 * braking * SubstepOf(*world));
}

}  // namespace
}  // namespace genphys::testing

// Damping and media against all that pushes at the same time: motors, joints, contacts and each other.
#include <cmath>
#include <functional>
#include <numbers>

#include "conformance/engine_test.h"
#include "support/course.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Resistance, Claim::kJointHinge, Claim::kJointSlider, Claim::kJointMotor, Claim::kDragField);

constexpr double kGravity = 9.81;
constexpr double kStep = 1.0 / 60;
constexpr double kMass = 2, kRadius = 0.5, kMoment = 0.4 * kMass * kRadius * kRadius;
// Of the step a quarter, and of an error of second order a sixteenth.
constexpr double kFiner = 4, kLess = 12;

/// By which of the two a body is resisted.
enum class By { kDamping, kMedium };

JointAxis Pushed(double force) {
  return {.limits = {}, .motor = Motor{.target_velocity = 1e3, .force_max = force}, .spring = {}};
}

TEST_P(Resistance, AMotorComesToTheSpeedAtWhichItIsInBalance) {
  for (const By by : {By::kDamping, By::kMedium}) {
    for (const double rate : {5.0, 50.0, 500.0}) {
      constexpr double kSpeed = 10;
      const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
      EntityDesc wheel = Ball({0, 0, 0}, kRadius, kMass), sled = Ball({9, 0, 0}, kRadius, kMass);
      if (by == By::kDamping) wheel.rigid_body->angular_damping = sled.rigid_body->linear_damping = rate;
      const EntityId wheel_id = Add(*world, wheel), sled_id = Add(*world, sled);
      const JointId hinge = Join(*world, ToWorld(wheel_id, HingeJoint{Pushed(kSpeed * rate * kMoment)}));
      Join(*world, ToWorld(sled_id, SliderJoint{Pushed(kSpeed * rate * kMass)}, {Vector3(9, 0, 0), {}}));
      if (by == By::kMedium) {
        Do(*world, CreateForceField{{DragField{.linear = rate * kMass, .angular = rate * kMoment}}});
      }

      Steps(*world, 480);

      EXPECT_NEAR(SpinOf(*world, wheel_id).z(), kSpeed, kDirect * kSpeed) << rate;
      EXPECT_NEAR(VelocityOf(*world, sled_id).z(), kSpeed, kDirect * kSpeed) << rate;
      const double torque = kSpeed * rate * kMoment;
      EXPECT_NEAR(StateOf(*world, hinge).torque.z(), torque, kDirect * torque) << rate;
    }
  }
}

TEST_P(Resistance, ATorqueTurnsWhatIsFreeAsFastAsThatIsInBalance) {
  for (const By by : {By::kDamping, By::kMedium}) {
    for (const double rate : {5.0, 50.0, 500.0}) {
      constexpr double kSpeed = 10;
      const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
      EntityDesc wheel = Ball({0, 0, 0}, kRadius, kMass);
      if (by == By::kDamping) wheel.rigid_body->angular_damping = rate;
      const EntityId id = Add(*world, wheel);
      if (by == By::kMedium) Do(*world, CreateForceField{{DragField{.angular = rate * kMoment}}});

      Do(*world, ApplyForce{.id = id, .torque = {0, 0, kSpeed * rate * kMoment}, .steps = 480});
      Steps(*world, 480);

      EXPECT_NEAR(SpinOf(*world, id).z(), kSpeed, kDirect * kSpeed) << rate;
    }
  }
}

// What is small is stopped by it in less than 1e-13 s, and turns by torque / drag all the time from then on.
TEST_P(Resistance, ATorqueTurnsWhatIsSmallInAThickMediumAsFastAsThatIsInBalance) {
  Proves({Claim::kForce});
  struct Case {
    double half, mass, drag, torque;
  };
  for (const Case& each : {Case{5e-4, 3.2e-7, 1, 1e-3},
                           {1e-3, 2.56e-6, 1e-3, 1e-2},
                           {1e-4, 2.56e-9, 1, 1e-4},
                           {0.5, 1e-7, 10, 100},
                           {0.5, 1e-7, 1e12, 1e12}}) {
    const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
    EntityDesc brick = Body(Box{each.half * Vector3(1, 0.8, 0.4)}, {0, 0, 0}, each.mass);
    brick.pose.orientation = Quaternion(Eigen::AngleAxisd(1, Vector3(1, 2, 3).normalized()));
    const EntityId id = Add(*world, brick);
    Do(*world, CreateForceField{{DragField{.angular = each.drag}}});
    constexpr int kSteps = 10;
    const double speed = each.torque / each.drag;

    Do(*world, ApplyForce{.id = id, .torque = {0, 0, each.torque}, .steps = kSteps});
    for (int i = 0; i < kSteps - 1; ++i) {
      ASSERT_TRUE(world->Step().ok()) << each.half;
      EXPECT_LE((SpinOf(*world, id) - Vector3(0, 0, speed)).norm(), kDirect * speed) << each.half << ", " << i;
    }
    ASSERT_TRUE(world->Step().ok());
    const Quaternion turned =
        Quaternion(Eigen::AngleAxisd(speed * kSteps * kStep, Vector3::UnitZ())) * brick.pose.orientation;
    EXPECT_LE(FromColumn(world->state().orientations.col(id.index())).angularDistance(turned),
              kDirect * speed * kSteps * kStep + kRounded)
        << each.half;
    Steps(*world, 2);
    EXPECT_LE(SpinOf(*world, id).norm(), kDirect * speed) << "nothing drives it";
  }
}

TEST_P(Resistance, ATorqueAgainstTheStrongestDampingGivesABrickTheMomentumOfBalance) {
  Proves({Claim::kForce, Claim::kDamping});
  for (const double step : {kStep, 0.25}) {
    const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
    constexpr double kDamping = 1e4, kTorque = 1e5;
    EntityDesc brick = Body(Box{{0.5, 0.4, 0.2}}, {0, 0, 0}, kMass);
    brick.rigid_body->angular_damping = kDamping;
    brick.pose.orientation = Quaternion(Eigen::AngleAxisd(1, Vector3(1, 2, 3).normalized()));
    const EntityId id = Add(*world, brick);
    Do(*world, ApplyForce{.id = id, .torque = {0, 0, kTorque}, .steps = 100});
    const Matrix3& tensor = world->scene().entities[id.index()]->mass.tensor;
    for (int i = 0; i < 8; ++i) {
      ASSERT_TRUE(world->Step(step).ok());
      const Matrix3 axes = FromColumn(world->state().orientations.col(id.index())).toRotationMatrix();
      const Vector3 momentum = axes * tensor * axes.transpose() * SpinOf(*world, id);
      EXPECT_LE((momentum - Vector3(0, 0, kTorque / kDamping)).norm(), kDirect * kTorque / kDamping) << step;
    }
  }
}

/// The angle (rad) or place (m) that `law` leads to in a second.
template <typename Law>
double Course(double place, double rate, const Law& law) {
  constexpr int kParts = 20000;
  return CourseOf(place, rate, 1, kParts, law).first;
}

/// Expects of what a scene with steps of so many seconds is off by after a second that it is less than `most`, and of
/// second order.
void ExpectSecondOrder(double most, const std::function<double(double step_size)>& error) {
  const double coarse = error(kStep), fine = error(kStep / kFiner);
  EXPECT_LT(coarse, most);
  EXPECT_GT(coarse, kLess * fine);
}

TEST_P(Resistance, ADampedPendulumIsMetInSecondOrder) {
  constexpr double kArm = 1, kLinear = 0.7, kAngular = 0.5;  // m, 1/s, 1/s
  const double inertia = kMoment + kMass * kArm * kArm;
  const double wanted = Course(0, 0, [&](double angle, double rate) {
    const double braking = (kLinear * kMass * kArm * kArm + kAngular * kMoment) * rate;
    return (kMass * kGravity * kArm * std::cos(angle) - braking) / inertia;
  });
  for (const By by : {By::kDamping, By::kMedium}) {
    ExpectSecondOrder(4e-4, [&](double step_size) {
      const auto world = MakeSpace(GetParam(), {.step_size = step_size});
      EntityDesc ball = Ball({kArm, 0, 0}, kRadius, kMass);
      if (by == By::kDamping) {
        ball.rigid_body->linear_damping = kLinear;
        ball.rigid_body->angular_damping = kAngular;
      } else {
        Do(*world, CreateForceField{{DragField{.linear = kLinear * kMass, .angular = kAngular * kMoment}}});
      }
      const EntityId id = Add(*world, ball);
      Join(*world, ToWorld(id, HingeJoint{}, FrameAlong(Vector3::UnitY())));
      Steps(*world, static_cast<int>(std::lround(1 / step_size)));
      const Vector3 at = PositionOf(*world, id);
      return std::abs(std::remainder(std::atan2(-at.z(), at.x()) - wanted, 2 * std::numbers::pi));
    });
  }
}

TEST_P(Resistance, WhatRollsDownASlopeAgainstDampingIsMetInSecondOrder) {
  Proves({Claim::kKineticFriction});
  constexpr double kPull = 1, kAngular = 20;  // m/s^2 along the floor, 1/s
  // m v' = m g - f and I w' = f r - c I w, with v = w r.
  const double rolls = kMass / (kMass + kMoment / (kRadius * kRadius));
  const double wanted =
      Course(0, 0, [&](double, double speed) { return rolls * kPull - (1 - rolls) * kAngular * speed; });
  ExpectSecondOrder(2e-4, [&](double step_size) {
    const auto world = testing::MakeWorld(
        WorldDesc{.engine = GetParam(), .gravity = {kPull, 0, -kGravity}, .stepper = {.step_size = step_size}});
    EntityDesc ball = Ball({0, 0, kRadius}, kRadius, kMass);
    ball.rigid_body->angular_damping = kAngular;
    const EntityId id = Add(*world, ball);
    Steps(*world, static_cast<int>(std::lround(1 / step_size)));
    return std::abs(PositionOf(*world, id).x() - wanted);
  });
}

TEST_P(Resistance, SeveralMediaAtOnceAreMetInSecondOrder) {
  constexpr double kLinear = 0.7, kWind = 4, kThick = 0.5, kThin = 0.2, kStart = 8;
  const double wanted = Course(0, kStart, [&](double, double speed) {
    const double in_wind = speed - kWind;
    return -kLinear * speed - (kThick * std::abs(in_wind) * in_wind + kThin * speed * std::abs(speed)) / kMass;
  });
  ExpectSecondOrder(1e-3, [&](double step_size) {
    const auto world = MakeSpace(GetParam(), {.step_size = step_size}, Vector3::Zero());
    EntityDesc ball = Ball({0, 0, 0}, kRadius, kMass);
    ball.rigid_body->linear_velocity = {kStart, 0, 0};
    ball.rigid_body->linear_damping = kLinear;
    const EntityId id = Add(*world, ball);
    Do(*world, CreateForceField{{DragField{.quadratic = kThick, .medium_velocity = {kWind, 0, 0}}}});
    Do(*world, CreateForceField{{DragField{.quadratic = kThin}}});
    Steps(*world, static_cast<int>(std::lround(1 / step_size)));
    return std::abs(PositionOf(*world, id).x() - wanted);
  });
}

TEST_P(Resistance, DampingAndWindAgreeOnASpeed) {
  constexpr double kRate = 5, kWind = 3;
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  EntityDesc ball = Ball({0, 0, 0}, kRadius, kMass);
  ball.rigid_body->linear_damping = kRate;
  const EntityId id = Add(*world, ball);
  Do(*world, CreateForceField{{DragField{.linear = kRate * kMass, .medium_velocity = {kWind, 0, 0}}}});

  Steps(*world, 240);

  EXPECT_NEAR(VelocityOf(*world, id).x(), kWind / 2, kRounded * kWind);
}

TEST_P(Resistance, AJointHoldsAgainstGravityHoweverDamped) {
  for (const double rate : {1.0, 50.0, 500.0}) {
    const auto world = MakeSpace(GetParam());
    EntityDesc ball = Ball({0, 0, 0}, kRadius, kMass);
    ball.rigid_body->linear_damping = ball.rigid_body->angular_damping = rate;
    const EntityId id = Add(*world, ball);
    const JointId joint = Join(*world, ToWorld(id, FixedJoint{}));

    Steps(*world, 480);

    EXPECT_NEAR(PositionOf(*world, id).z(), 0, 1e-6) << rate;
    EXPECT_NEAR(StateOf(*world, joint).force.z(), kMass * kGravity, 1e-6 * kMass * kGravity) << rate;
  }
}

}  // namespace
}  // namespace genphys::testing

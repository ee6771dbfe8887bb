// Motors to a speed along lines that turn: what they drive has gone as far as that speed says.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsTurningMotors);

constexpr double kFirst = 0.4;  // m
constexpr double kTime = 0.5;   // s

JointAxis Driven(double speed, std::optional<double> force_max) {
  return {.limits = {}, .motor = Motor{.target_velocity = speed, .force_max = force_max}, .spring = {}};
}

std::unique_ptr<World> MakeSpaceAt(const std::string& engine, int rate) {
  StepperDesc stepper;
  stepper.step_size = 1.0 / rate;
  return MakeSpace(engine, stepper, Vector3::Zero());
}

// A body that turns about the origin at `turning` (rad/s), and goes away from it at `speed` (m/s).
EntityDesc Turner(double x, double turning, double speed) {
  EntityDesc desc = Ball({x, 0, 0}, 0.2);
  desc.rigid_body->linear_velocity = {speed, x * turning, 0};
  desc.rigid_body->angular_velocity = {0, 0, turning};
  return desc;
}

// How far a bead on a free arm is from the middle of it after kTime, if it went outwards at `speed` from the beginning.
double WayAlongArm(const std::string& engine, const JointKind& kind, double speed, int rate) {
  constexpr double kTurning = 4;
  const auto world = MakeSpaceAt(engine, rate);
  const EntityId arm = Add(*world, Turner(0, kTurning, 0)), bead = Add(*world, Turner(kFirst, kTurning, speed));
  Join(*world, ToWorld(arm, HingeJoint{}));
  Join(*world, Between(arm, bead, kind, FrameAlong(Vector3::UnitX(), {kFirst, 0, 0})));
  Steps(*world, static_cast<int>(std::lround(kTime * rate)));
  return PositionOf(*world, bead).norm();
}

TEST_P(JointsTurningMotors, DriveABeadAlongAnArmThatTurns) {
  Proves({Claim::kJointSlider, Claim::kJointSixDof, Claim::kJointMotor});
  constexpr double kSpeed = 0.5;
  for (const std::optional<double> force_max : {std::optional<double>(), std::optional<double>(50)}) {
    SixDofJoint free_along;
    free_along.along[2] = Driven(kSpeed, force_max);
    for (const JointKind& kind : {JointKind(SliderJoint{Driven(kSpeed, force_max)}), JointKind(free_along)}) {
      for (const int rate : {60, 120, 240}) {
        EXPECT_NEAR(WayAlongArm(GetParam(), kind, kSpeed, rate), kFirst + kSpeed * kTime, 0.2 / (rate * rate))
            << "kind " << kind.index() << ", " << rate << " steps per second";
      }
    }
  }
}

TEST_P(JointsTurningMotors, WindUpWhatCircles) {
  Proves({Claim::kJointDistance, Claim::kJointMotor});
  constexpr double kSpeed = -0.3, kTurning = 3;
  for (const int rate : {60, 120, 240}) {
    const auto world = MakeSpaceAt(GetParam(), rate);
    const EntityId ball = Add(*world, Turner(1, kTurning, kSpeed));
    JointDesc winch = ToWorld(ball, DistanceJoint{Driven(kSpeed, {})});
    winch.frame_in_b = Pose{};
    Join(*world, winch);
    Steps(*world, static_cast<int>(std::lround(kTime * rate)));
    EXPECT_NEAR(PositionOf(*world, ball).norm(), 1 + kSpeed * kTime, 0.2 / (rate * rate)) << rate;
  }
}

}  // namespace
}  // namespace genphys::testing

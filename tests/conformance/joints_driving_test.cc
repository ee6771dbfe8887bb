// What drives a joint: motors, limits, springs.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsDriving);

constexpr double kGravity = 9.81;
constexpr double kMoment = 0.4 * 0.25;  // of a ball of 1 kg and half a metre, kg*m^2

JointAxis Driven(double velocity, std::optional<double> force_max = {}) {
  return {.limits = {}, .motor = Motor{.target_velocity = velocity, .force_max = force_max}, .spring = {}};
}

TEST_P(JointsDriving, AMotorSpinsAFlywheelUpWithItsTorqueAndHoldsTheSpeed) {
  Proves({Claim::kJointHinge, Claim::kJointMotor});
  constexpr double kTorque = 0.3, kTarget = 5;
  const auto world = MakeSpace(GetParam());
  const EntityId wheel = Add(*world, Ball({0, 0, 0}));
  const JointId joint = Join(*world, ToWorld(wheel, HingeJoint{Driven(kTarget, kTorque)}));
  Steps(*world, 60);
  EXPECT_NEAR(SpinOf(*world, wheel).z(), kTorque / kMoment, kDirect * kTarget) << "a second of constant torque";
  EXPECT_NEAR(StateOf(*world, joint).torque.z(), kTorque, kDirect * kTorque);
  Steps(*world, 60);
  EXPECT_NEAR(SpinOf(*world, wheel).z(), kTarget, kDirect * kTarget);
  EXPECT_NEAR(StateOf(*world, joint).rates[5], kTarget, kDirect * kTarget);
  EXPECT_LE(StateOf(*world, joint).torque.norm(), kDirect * kTorque) << "nothing slows it down";
}

TEST_P(JointsDriving, AHingeCountsItsTurns) {
  Proves({Claim::kJointHinge, Claim::kJointMotor});
  const auto world = MakeSpace(GetParam());
  const EntityId wheel = Add(*world, Ball({0, 0, 0}));
  const JointId joint = Join(*world, ToWorld(wheel, HingeJoint{Driven(-7)}));
  Steps(*world, 300);
  EXPECT_NEAR(StateOf(*world, joint).positions[5], -35, 35 * kDirect);
}

TEST_P(JointsDriving, AnArmRestsOnTheLimitOfItsHinge) {
  Proves({Claim::kJointHinge, Claim::kJointLimit});
  constexpr double kLimit = 0.7;
  const auto world = MakeSpace(GetParam());
  // About y it falls from the horizontal to where the limit holds it.
  const EntityId arm = Add(*world, Ball({1, 0, 0}, 0.1));
  HingeJoint hinge;
  hinge.axis.limits.upper = kLimit;
  const JointId joint = Join(*world, ToWorld(arm, hinge, FrameAlong(Vector3::UnitY())));
  for (int i = 0; i < 240; ++i) {
    Steps(*world, 1);
    // The turn about a fixed axis is exact.
    ASSERT_LE(StateOf(*world, joint).positions[5], kLimit + kDirect * kLimit) << "step " << i;
  }
  EXPECT_NEAR(StateOf(*world, joint).positions[5], kLimit, kDirect * kLimit);
  const double moment = kGravity * std::cos(kLimit);
  EXPECT_NEAR(StateOf(*world, joint).torque.y(), -moment, kDirect * moment);
}

TEST_P(JointsDriving, AMotorDoesNotFightTheLimit) {
  Proves({Claim::kJointMotor, Claim::kJointLimit});
  const auto world = MakeSpace(GetParam());
  const EntityId wheel = Add(*world, Ball({0, 0, 0}));
  HingeJoint hinge{Driven(3)};
  hinge.axis.limits.upper = 1;
  const JointId joint = Join(*world, ToWorld(wheel, hinge));
  Steps(*world, 120);
  EXPECT_NEAR(StateOf(*world, joint).positions[5], 1, kDirect);
  EXPECT_LE(SpinOf(*world, wheel).norm(), kDirect);
}

TEST_P(JointsDriving, ASliderOnASpringSwingsAsTheClosedFormSays) {
  Proves({Claim::kJointSlider, Claim::kJointSpring});
  constexpr double kStiffness = 10, kDamping = 0.5, kMass = 1, kStart = 0.3;
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const EntityId box = Add(*world, Crate({0, 0, kStart}, 0.1, kMass));
  SliderJoint slider;
  slider.axis.spring = Spring{.stiffness = kStiffness, .damping = kDamping};
  JointDesc joint = ToWorld(box, slider);
  joint.frame_in_b = Pose{};
  const JointId id = Join(*world, joint);
  const double h = SubstepOf(*world);
  const auto substeps = std::lround(1 / (60 * h));
  const double decay = kDamping / (2 * kMass), pulse = std::sqrt(kStiffness / kMass - decay * decay);
  // Between the middles of the substeps; the first one acts for half of it only. The place that the spring feels is the
  // mean of those before, at and after the substep with weights 1, 2 and 1, and the velocity that before and after it.
  double position = kStart, velocity = 0;
  for (int i = 1; i <= 60; ++i) {
    Steps(*world, 1);
    for (int substep = 0; substep < substeps; ++substep) {
      const double time = i == 1 && substep == 0 ? h / 2 : h;
      const double inertia = h * h / 4 * kStiffness, resistance = time / 2 * kDamping;
      velocity =
          ((kMass + inertia - resistance) * velocity - time * kStiffness * position) / (kMass + inertia + resistance);
      position += h * velocity;
    }
    const double t = i / 60.0;
    const double exact = kStart * std::exp(-decay * t) * (std::cos(pulse * t) + decay / pulse * std::sin(pulse * t));
    // Its phase is behind by w t (w h)^2 / 12.
    const double predicted = kStart * pulse * t * std::pow(pulse * h, 2) / 12;
    ASSERT_NEAR(PositionOf(*world, box).z(), exact, 2 * predicted + kDirect * kStart) << "at " << t;
    ASSERT_NEAR(PositionOf(*world, box).z(), position, kDirect * kStart) << "the same on every engine";
    ASSERT_NEAR(StateOf(*world, id).positions[2], position, kDirect * kStart);
  }
}

// A step resolves a damper by how hard all that it turns is to turn about the joint, and not by how easily the body
// alone would turn about its centre of mass.
TEST_P(JointsDriving, ADampedSpringIsAsGoodFarFromTheCentreOfMassAsInIt) {
  Proves({Claim::kJointHinge, Claim::kJointSixDof, Claim::kJointSpring});
  constexpr double kMass = 2, kArm = 0.5, kPulse = 15, kZeta = 0.5, kStart = 1;
  constexpr double kInertia = kMass * (0.05 * 0.05 + 0.1 * 0.1) / 3 + kMass * kArm * kArm;
  HingeJoint hinge;
  hinge.axis.spring =
      Spring{.stiffness = kInertia * kPulse * kPulse, .damping = 2 * kZeta * kPulse * kInertia, .rest = -kStart};
  SixDofJoint six;
  six.about[2] = hinge.axis;
  for (const double rate : {60.0, 120.0, 240.0}) {
    for (const JointKind& kind : {JointKind(hinge), JointKind(six)}) {
      SCOPED_TRACE(rate);
      const auto world = MakeSpace(GetParam(), {.step_size = 1 / rate}, Vector3::Zero());
      const EntityId arm = Add(*world, Body(Box{{0.05, 0.05, 0.1}}, {kArm, 0, 0}, kMass));
      const JointId joint = Join(*world, ToWorld(arm, kind, FrameAlong(Vector3::UnitY())));
      const double decay = kZeta * kPulse, pulse = kPulse * std::sqrt(1 - kZeta * kZeta);
      // Its phase is behind by w t (w h)^2 / 12, of what is left of the swing.
      const double predicted = kStart * std::pow(kPulse * SubstepOf(*world), 2) / 12 / (kZeta * std::exp(1));
      for (int i = 1; i <= rate / 5; ++i) {
        Steps(*world, 1);
        const double t = i / rate;
        const double left = std::exp(-decay * t) * (std::cos(pulse * t) + decay / pulse * std::sin(pulse * t));
        ASSERT_NEAR(StateOf(*world, joint).positions[5], kStart * (left - 1), 2 * predicted) << "at " << t;
      }
    }
  }
}

TEST_P(JointsDriving, ASliderKeepsToItsPathAndItsEnd) {
  Proves({Claim::kJointSlider, Claim::kJointLimit});
  const auto world = MakeSpace(GetParam());
  // Down a slope of 30 degrees, with its weight beside the path.
  const Vector3 down(std::cos(M_PI / 6), 0, -std::sin(M_PI / 6));
  EntityDesc cart = Crate({0, 0, 0}, 0.2, 2);
  cart.rigid_body->inertia.center_of_mass = Vector3(0, 0.1, 0.3);
  const EntityId id = Add(*world, cart);
  SliderJoint slider;
  slider.axis.limits.upper = 2;
  const JointId joint = Join(*world, ToWorld(id, slider, FrameAlong(down)));
  Steps(*world, 30);
  const double t = 0.5, way = kGravity / 2 * t * t / 2;
  EXPECT_NEAR(StateOf(*world, joint).positions[2], way, kDirect * way);
  Steps(*world, 90);
  EXPECT_NEAR(StateOf(*world, joint).positions[2], 2, 2 * kDirect);
  EXPECT_LE((PositionOf(*world, id) - 2 * down).norm(), 2 * kDirect);
  EXPECT_NEAR(StateOf(*world, joint).force.norm(), 2 * kGravity, 2 * kGravity * kDirect);
}

TEST_P(JointsDriving, AMotorPushesASliderWithNoMoreThanItsForce) {
  Proves({Claim::kJointSlider, Claim::kJointMotor});
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const EntityId cart = Add(*world, Crate({0, 0, 0}, 0.2, 2));
  const JointId joint = Join(*world, ToWorld(cart, SliderJoint{Driven(1, 3)}));
  Steps(*world, 30);
  EXPECT_NEAR(VelocityOf(*world, cart).z(), 0.75, kDirect);
  Steps(*world, 30);
  EXPECT_NEAR(VelocityOf(*world, cart).z(), 1, kDirect);
  EXPECT_NEAR(StateOf(*world, joint).rates[2], 1, kDirect);
}

// A load pulls it down past the speed that the motor is to drive it to. Until then the motor helps the load, and from
// then on it pushes against it, in the middle of a step.
TEST_P(JointsDriving, AMotorThatIsTooWeakForItsLoadTurnsWhenTheSpeedIsReached) {
  Proves({Claim::kJointSlider, Claim::kJointHinge, Claim::kJointMotor});
  constexpr double kForce = 0.6 * kGravity, kFirst = 1.2, kTarget = -0.6, kDuration = 1;
  const double turns_at = (kFirst - kTarget) / (kGravity + kForce), left = kDuration - turns_at;
  const double speed = kTarget - (kGravity - kForce) * left;
  const double way = (kFirst + kTarget) / 2 * turns_at + (kTarget + speed) / 2 * left;
  for (const double step : {1.0 / 60, 1.0 / 137, 1.0 / 240}) {
    for (const bool slides : {true, false}) {
      const auto world = MakeSpace(GetParam(), {.step_size = step}, {0, 0, slides ? -kGravity : 0});
      EntityDesc ball = Ball({0, 0, 0});
      ball.rigid_body->linear_velocity = {0, 0, slides ? kFirst : 0};
      ball.rigid_body->angular_velocity = {0, 0, slides ? 0 : kFirst};
      const EntityId id = Add(*world, ball);
      const JointAxis axis = Driven(kTarget, slides ? kForce : kForce * kMoment);
      const JointId joint = Join(*world, ToWorld(id, slides ? JointKind(SliderJoint{axis}) : HingeJoint{axis}));
      if (!slides) Do(*world, ApplyForce{.id = id, .torque = {0, 0, -kGravity * kMoment}, .steps = 1000});
      while (world->layer_state().simulation_time < kDuration - step / 2) Steps(*world, 1);
      const double late = world->layer_state().simulation_time - kDuration;
      const JointState now = StateOf(*world, joint);
      const size_t coordinate = slides ? 2 : 5;
      EXPECT_NEAR(now.rates[coordinate], speed - (kGravity - kForce) * late, kDirect) << step;
      // By as much the ways of a step with both accelerations differ.
      const double error = kForce * step * step;
      EXPECT_NEAR(now.positions[coordinate], way + speed * late, error) << step;
    }
  }
}

// One hangs on the other. The upper motor comes to its speed first and cannot hold its load; the lower one, which would
// not be there in that substep, is there soon after, for it is no longer carried along, and holds its own.
TEST_P(JointsDriving, MotorsThatTurnInTheSameStepDoSoOneAfterTheOther) {
  Proves({Claim::kJointSlider, Claim::kJointMotor});
  constexpr double kUpper = 4, kLower = 3, kTarget = -0.4, kDuration = 1;
  // Of balls of 1 kg: until the upper one is there, until both are, and from then on.
  constexpr double kFalls = -kUpper + kLower - kGravity, kBraked = kUpper + kLower - kGravity;
  constexpr double kParts = -kLower - kGravity - kFalls, kPartsFast = -kLower - kGravity - kBraked;
  constexpr double kFirst = 0.5, kSecond = 0.002;
  for (const double step : {1.0 / 60, 1.0 / 136, 1.0 / 240}) {
    const auto world = MakeSpace(GetParam(), {.step_size = step});
    EntityDesc upper = Ball({0, 0, 0}), lower = Ball({0, 0, -3});
    upper.rigid_body->linear_velocity = {0, 0, kTarget - kFirst * kFalls};
    const double parting = kTarget - kFirst * kParts - kSecond * kPartsFast;
    lower.rigid_body->linear_velocity = {0, 0, upper.rigid_body->linear_velocity.z() + parting};
    const EntityId bearer = Add(*world, upper), load = Add(*world, lower);
    const JointId above = Join(*world, ToWorld(bearer, SliderJoint{Driven(kTarget, kUpper)}));
    const JointId below = Join(*world, Between(bearer, load, SliderJoint{Driven(kTarget, kLower)}));
    while (world->layer_state().simulation_time < kDuration - step / 2) Steps(*world, 1);
    const double left = world->layer_state().simulation_time - kFirst - kSecond;
    // Both go together from then on.
    EXPECT_NEAR(StateOf(*world, above).rates[2], kTarget + kSecond * kBraked + left * (kUpper / 2 - kGravity), kDirect)
        << step;
    EXPECT_NEAR(StateOf(*world, below).rates[2], kTarget, kDirect) << step;
  }
}

TEST_P(JointsDriving, AMotorDrivesToAPosition) {
  Proves({Claim::kJointMotor});
  const auto world = MakeSpace(GetParam());
  const EntityId arm = Add(*world, Ball({1, 0, 0}, 0.1));
  HingeJoint hinge;
  hinge.axis.motor = Motor{.target_position = -0.5, .stiffness = 200, .damping = 40};
  const JointId joint = Join(*world, ToWorld(arm, hinge, FrameAlong(Vector3::UnitY())));
  Steps(*world, 600);
  // At rest the spring carries the weight: k (target - x) = -m g cos(x).
  const double angle = StateOf(*world, joint).positions[5];
  EXPECT_NEAR(200 * (-0.5 - angle), -kGravity * std::cos(angle), kDirect * kGravity);
  EXPECT_LE(SpinOf(*world, arm).norm(), kDirect);
}

TEST_P(JointsDriving, LiveChangesTakeEffect) {
  Proves({Claim::kJointChange});
  const auto world = MakeSpace(GetParam());
  const EntityId wheel = Add(*world, Ball({0, 0, 0}));
  const JointId joint = Join(*world, ToWorld(wheel, HingeJoint{Driven(2)}));
  Steps(*world, 1);
  EXPECT_NEAR(SpinOf(*world, wheel).z(), 2, 2 * kDirect);

  UpdateJoint update{.id = joint, .joint = {.kind = HingeJoint{Driven(-4)}}, .fields = {}};
  update.fields.Add(JointField::kMotor);
  Do(*world, update);
  Steps(*world, 1);
  EXPECT_NEAR(SpinOf(*world, wheel).z(), -4, 4 * kDirect);

  Do(*world, SetMotorColumns{.ids = {joint}, .velocities = {6}, .positions = {}});
  Steps(*world, 1);
  EXPECT_NEAR(SpinOf(*world, wheel).z(), 6, 6 * kDirect);

  // Another kind altogether: now it may only slide.
  update.joint.kind = SliderJoint{};
  update.fields.Add(JointField::kKind);
  update.fields.bits &= ~static_cast<uint32_t>(JointField::kMotor);
  Do(*world, update);
  Steps(*world, 30);
  EXPECT_LE(SpinOf(*world, wheel).norm(), kDirect);
  EXPECT_LT(PositionOf(*world, wheel).z(), -0.5);
}

}  // namespace
}  // namespace genphys::testing

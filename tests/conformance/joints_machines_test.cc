// Joints that machines are made of: wheels, universal joints, gears, and six-dof joints with some of them free.
#include <cmath>
#include <numbers>
#include <utility>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsMachines);

constexpr double kGravity = 9.81;

JointAxis Driven(double velocity, std::optional<double> force_max = {}) {
  return {.limits = {}, .motor = Motor{.target_velocity = velocity, .force_max = force_max}, .spring = {}};
}

TEST_P(JointsMachines, AWheelSagsOnItsSuspensionAndIsSteeredWhileItSpins) {
  Proves({Claim::kJointWheel, Claim::kJointSpring});
  constexpr double kMass = 5, kStiffness = 1000, kSteering = 0.4, kSpin = 6;
  const auto world = MakeSpace(GetParam());
  const EntityId chassis = Add(*world, Block({0, 0, 2}, {1, 1, 0.1}));
  const EntityId wheel = Add(*world, Ball({0, 0, 0}, 0.3, kMass));
  WheelJoint kind;
  kind.suspension = JointAxis{.limits = {}, .motor = {}, .spring = Spring{.stiffness = kStiffness, .damping = 150}};
  kind.steering = JointAxis{
      .limits = {}, .motor = Motor{.target_position = kSteering, .stiffness = 500, .damping = 50}, .spring = {}};
  kind.spin = Driven(kSpin, 5);
  JointDesc joint = Between(chassis, wheel, kind, Pose{{0, 0, -2}, {1, 0, 0, 0}});
  joint.frame_in_b = Pose{};
  const JointId id = Join(*world, joint);
  Steps(*world, 600);

  const JointState state = StateOf(*world, id);
  const double sag = kMass * kGravity / kStiffness;
  EXPECT_NEAR(state.positions[2], -sag, kDirect * sag);
  EXPECT_NEAR(state.positions[5], kSteering, kDirect * kSteering);
  EXPECT_NEAR(state.rates[4], kSpin, kSpin * kDirect);
  // The axle has turned with the steering, and the wheel counts its turns about it.
  EXPECT_LE((SpinOf(*world, wheel) - kSpin * Vector3(-std::sin(kSteering), std::cos(kSteering), 0)).norm(),
            kSpin * kDirect);
  EXPECT_GT(state.positions[4], 8 * 2 * M_PI);
  EXPECT_LE(PositionOf(*world, wheel).head<2>().norm(), kDirect) << "it keeps to its strut";
}

TEST_P(JointsMachines, AUniversalJointTransmitsAsTheClosedFormSays) {
  Proves({Claim::kJointUniversal});
  constexpr double kBend = 0.5, kSpeed = 2;
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const Vector3 along(std::sin(kBend), 0, std::cos(kBend));
  const EntityId input = Add(*world, Ball({0, 0, -1}, 0.2));
  EntityDesc bent = Ball(along, 0.2);
  bent.pose.orientation = Quaternion(Eigen::AngleAxisd(kBend, Vector3::UnitY()));
  const EntityId output = Add(*world, bent);
  const JointId first = Join(*world, ToWorld(input, HingeJoint{Driven(kSpeed)}, Pose{{0, 0, -1}, {1, 0, 0, 0}}));
  const JointId second = Join(*world, ToWorld(output, HingeJoint{}, Pose{along, bent.pose.orientation}));
  JointDesc cross = Between(input, output, UniversalJoint{}, Pose{{0, 0, 1}, {1, 0, 0, 0}});
  cross.frame_in_b = Pose{{0, 0, -1}, {1, 0, 0, 0}};
  Join(*world, cross);
  for (int i = 1; i <= 180; ++i) {
    Steps(*world, 1);
    const double in = StateOf(*world, first).positions[5], out = StateOf(*world, second).positions[5];
    EXPECT_NEAR(in, kSpeed * i / 60, kDirect * kSpeed * 3) << "step " << i;
    // The arm x of the input and the arm y of the output stay perpendicular: tan(in) = tan(out) cos(bend).
    const double expected = std::atan2(std::sin(in), std::cos(in) * std::cos(kBend));
    // What one substep adds beyond its tangent: acceleration h^2 / 2, of which a fifth is left from each before.
    const double h = SubstepOf(*world), acceleration = kSpeed * kSpeed * std::tan(kBend) * std::sin(kBend);
    EXPECT_NEAR(std::remainder(out - expected, 2 * M_PI), 0, 2 * 1.25 * acceleration * h * h / 2) << "step " << i;
  }
}

// Nothing but its joints acts on the shaft, and by rounding alone on its middle: that is no blow.
TEST_P(JointsMachines, AShaftBehindAUniversalJointTurnsAsFastAsTheClosedFormSays) {
  Proves({Claim::kJointUniversal});
  constexpr double kBend = 0.5, kSpeed = 2, kTime = 1;
  const Vector3 along(std::sin(kBend), 0, std::cos(kBend));
  for (const int rate : {60, 120}) {
    const auto world = MakeSpace(GetParam(), {.step_size = 1.0 / rate}, Vector3::Zero());
    EntityDesc driving = Ball({0, 0, -1}, 0.2);
    driving.rigid_body->motion_type = MotionType::kKinematic;
    driving.rigid_body->angular_velocity = kSpeed * Vector3::UnitZ();
    const EntityId input = Add(*world, driving);
    EntityDesc bent = Ball(along, 0.2);
    bent.pose.orientation = Quaternion(Eigen::AngleAxisd(kBend, Vector3::UnitY()));
    bent.rigid_body->angular_velocity = kSpeed / std::cos(kBend) * along;
    const EntityId output = Add(*world, bent);
    Join(*world, ToWorld(output, HingeJoint{}, Pose{along, bent.pose.orientation}));
    JointDesc cross = Between(input, output, UniversalJoint{}, Pose{{0, 0, 1}, {1, 0, 0, 0}});
    cross.frame_in_b = Pose{{0, 0, -1}, {1, 0, 0, 0}};
    Join(*world, cross);
    Steps(*world, rate);

    const double turned = kSpeed * kTime, cosine = std::cos(kBend) * std::cos(turned), sine = std::sin(turned);
    const double expected = kSpeed * std::cos(kBend) / (cosine * cosine + sine * sine);
    // Of second order: 3.3e-5 rad/s were measured at 60 steps per second, and 2.7e-3 with false blows.
    EXPECT_NEAR(SpinOf(*world, output).norm(), expected, 2 * 3.3e-5 * std::pow(60.0 / rate, 2)) << rate;
  }
}

TEST_P(JointsMachines, AGearKeepsItsRatio) {
  Proves({Claim::kJointGear});
  constexpr double kRatio = -2.5, kTorque = 0.2;
  const auto world = MakeSpace(GetParam());
  const EntityId a = Add(*world, Ball({0, 0, 0}, 0.5, 2)), b = Add(*world, Ball({2, 0, 0}, 0.3, 1));
  const Vector3 tilted = Vector3(1, 0, 2).normalized();
  const JointId axle = Join(*world, ToWorld(a, HingeJoint{}));
  Join(*world, ToWorld(b, HingeJoint{}, FrameAlong(tilted, {2, 0, 0})));
  JointDesc gear = Between(a, b, GearJoint{.ratio = kRatio});
  gear.frame_in_b = FrameAlong(tilted);
  const JointId id = Join(*world, gear);
  Do(*world, ApplyForce{.id = a, .torque = {0, 0, kTorque}, .steps = 60});
  Steps(*world, 60);

  // b weighs on a with its moment times the ratio squared.
  const double moment_a = 0.4 * 2 * 0.25, moment_b = 0.4 * 0.09;
  const double expected = kTorque / (moment_a + kRatio * kRatio * moment_b);
  EXPECT_NEAR(SpinOf(*world, a).z(), expected, expected * kDirect);
  EXPECT_NEAR(SpinOf(*world, b).dot(tilted), kRatio * expected, std::abs(kRatio) * expected * kDirect);
  EXPECT_NEAR(StateOf(*world, id).torque.dot(tilted), kRatio * moment_b * expected,
              kDirect * std::abs(kRatio) * moment_b * expected);
  EXPECT_NEAR(StateOf(*world, id).positions[5], 0, kDirect) << "it has not slipped";
  EXPECT_NEAR(StateOf(*world, axle).rates[5], expected, expected * kDirect);
}

TEST_P(JointsMachines, AGearOnWhatCannotMoveHoldsStill) {
  Proves({Claim::kJointGear});
  const auto world = MakeSpace(GetParam());
  EntityDesc motor = Ball({0, 0, 0});
  motor.rigid_body->motion_type = MotionType::kKinematic;
  const EntityId a = Add(*world, motor), b = Add(*world, Ball({2, 0, 0}));
  Join(*world, ToWorld(b, HingeJoint{}, Pose{{2, 0, 0}, {1, 0, 0, 0}}));
  Join(*world, Between(a, b, GearJoint{.ratio = 3}));
  Do(*world, ApplyForce{.id = b, .torque = {0, 0, 1}, .steps = 60});
  Steps(*world, 30);
  EXPECT_LE(SpinOf(*world, b).norm(), kDirect);
  Do(*world, SetVelocity{.id = a, .angular = Vector3(0, 0, 2)});
  Steps(*world, 30);
  EXPECT_NEAR(SpinOf(*world, b).z(), 6, 6 * kDirect);
}

TEST_P(JointsMachines, ASixDofJointHoldsWhatIsNotSetAndFreesWhatIs) {
  Proves({Claim::kJointSixDof});
  const auto world = MakeSpace(GetParam());
  const EntityId box = Add(*world, Body(Box{{0.2, 0.3, 0.4}}, {0, 0, 0}, 2));
  SixDofJoint joint;
  joint.along[0] = JointAxis{.limits = {.lower = -0.5, .upper = 0.5}, .motor = {}, .spring = {}};
  joint.about[2] = JointAxis{};
  const JointId id = Join(*world, ToWorld(box, joint));
  Do(*world, ApplyForce{.id = box, .force = {3, 50, 0}, .torque = {5, 5, 0.5}, .steps = 600});
  Steps(*world, 30);
  const double spin = 0.5 * 0.5 / (2.0 / 3 * (0.04 + 0.09));
  EXPECT_NEAR(SpinOf(*world, box).z(), spin, kDirect * spin) << "half a second of constant torque";
  Steps(*world, 90);

  const JointState state = StateOf(*world, id);
  EXPECT_NEAR(state.positions[0], 0.5, kDirect * 0.5) << "at its limit";
  EXPECT_LE((PositionOf(*world, box) - Vector3(0.5, 0, 0)).norm(), kDirect);
  const Vector3 up = world->state().pose(EntityRow{box.index()}).orientation * Vector3::UnitZ();
  EXPECT_LE((up - Vector3::UnitZ()).norm(), kDirect) << "it has not tilted";
  EXPECT_NEAR(state.force.y(), -50, 50 * kDirect);
  EXPECT_NEAR(state.force.z(), 2 * kGravity, 20 * kDirect);
}

TEST_P(JointsMachines, ASixDofJointWithoutAnyAxisIsAFixedOne) {
  Proves({Claim::kJointSixDof});
  const auto world = MakeSpace(GetParam());
  const EntityId beam = Add(*world, Body(Box{{1, 0.1, 0.1}}, {1, 0, 0}, 3));
  const JointId joint = Join(*world, ToWorld(beam, SixDofJoint{}));
  Steps(*world, 60);
  EXPECT_LE((StateOf(*world, joint).torque - Vector3(0, -3 * kGravity, 0)).norm(), 30 * kDirect);
  EXPECT_LE((PositionOf(*world, beam) - Vector3(1, 0, 0)).norm(), kDirect);
}

TEST_P(JointsMachines, ASixDofJointThatTurnsAboutOneAxisIsAHinge) {
  Proves({Claim::kJointSixDof});
  constexpr double kSpin = 4;
  for (int axis = 0; axis < 3; ++axis) {
    SCOPED_TRACE(axis);
    const auto world = MakeSpace(GetParam());
    EntityDesc box = Body(Box{{0.2, 0.3, 0.4}}, {0, 0, 0}, 2);
    box.rigid_body->angular_velocity = kSpin * Vector3::Unit(axis);
    const EntityId id = Add(*world, box);
    SixDofJoint joint;
    joint.about[static_cast<size_t>(axis)] = JointAxis{};
    const JointId held = Join(*world, ToWorld(id, joint));
    Steps(*world, 120);
    const double turned = kSpin * world->layer_state().simulation_time;
    EXPECT_NEAR(StateOf(*world, held).positions[static_cast<size_t>(3 + axis)], turned, turned * kDirect);
    EXPECT_LE((SpinOf(*world, id) - kSpin * Vector3::Unit(axis)).norm(), kSpin * kDirect);
    EXPECT_LE(PositionOf(*world, id).norm(), kDirect);
  }
}

// However far it goes about y: in a second by more than half a circle.
TEST_P(JointsMachines, ASixDofJointThatTurnsAboutXAndYIsAUniversalOne) {
  Proves({Claim::kJointSixDof, Claim::kJointUniversal});
  SixDofJoint joint;
  joint.about[0] = joint.about[1] = JointAxis{};
  const auto swing = [&](const JointKind& kind) {
    auto world = MakeSpace(GetParam());
    EntityDesc box = Body(Box{{0.2, 0.3, 0.4}}, {0.5, 0, -0.5}, 2);
    box.rigid_body->angular_velocity = {0.5, 4, 0};
    box.rigid_body->linear_velocity = box.rigid_body->angular_velocity.cross(Vector3(0.5, 0, -0.5));
    const EntityId id = Add(*world, box);
    const JointId held = Join(*world, ToWorld(id, kind));
    Steps(*world, 60);
    return std::pair(PositionOf(*world, id), StateOf(*world, held));
  };
  const auto [place, state] = swing(joint);
  const auto [wanted, other] = swing(UniversalJoint{});
  EXPECT_GT(std::abs(other.positions[4]), std::numbers::pi / 2);
  // What steps leave of the turn that is locked is measured in another way, and made up for.
  constexpr double kLeft = 1e-5;
  EXPECT_LE((place - wanted).norm(), kLeft);
  EXPECT_NEAR(state.positions[3], other.positions[3], kLeft);
  EXPECT_NEAR(state.positions[4], other.positions[4], kLeft);
}

}  // namespace
}  // namespace genphys::testing

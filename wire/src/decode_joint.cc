#include <optional>
#include <utility>

#include "genphys/wire/decode.h"
#include "values.h"

namespace genphys {
namespace {

AxisLimits DecodeLimits(const v1::AngleLimits& limits) {
  AxisLimits decoded;
  if (limits.has_lower_radians()) decoded.lower = limits.lower_radians();
  if (limits.has_upper_radians()) decoded.upper = limits.upper_radians();
  return decoded;
}

AxisLimits DecodeLimits(const v1::DistanceLimits& limits) {
  AxisLimits decoded;
  if (limits.has_lower_metres()) decoded.lower = limits.lower_metres();
  if (limits.has_upper_metres()) decoded.upper = limits.upper_metres();
  return decoded;
}

Motor DecodeMotor(const v1::AngularMotor& motor) {
  Motor decoded{.target_velocity = motor.target_velocity(), .stiffness = motor.stiffness(), .damping = motor.damping()};
  if (motor.has_target_radians()) decoded.target_position = motor.target_radians();
  if (motor.has_torque_max()) decoded.force_max = motor.torque_max();
  return decoded;
}

Motor DecodeMotor(const v1::LinearMotor& motor) {
  Motor decoded{.target_velocity = motor.target_velocity(), .stiffness = motor.stiffness(), .damping = motor.damping()};
  if (motor.has_target_metres()) decoded.target_position = motor.target_metres();
  if (motor.has_force_max()) decoded.force_max = motor.force_max();
  return decoded;
}

Spring DecodeSpring(const v1::AngularSpring& spring) {
  return {spring.stiffness(), spring.damping(), spring.rest_radians()};
}

Spring DecodeSpring(const v1::LinearSpring& spring) {
  return {spring.stiffness(), spring.damping(), spring.rest_metres()};
}

// Of an axis, or of a joint that has one axis and no more.
template <typename Message>
JointAxis DecodeAxis(const Message& axis) {
  JointAxis decoded{.limits = DecodeLimits(axis.limits()), .motor = {}, .spring = {}};
  if (axis.has_motor()) decoded.motor = DecodeMotor(axis.motor());
  if (axis.has_spring()) decoded.spring = DecodeSpring(axis.spring());
  return decoded;
}

template <typename Message>
std::optional<JointAxis> DecodeIf(bool set, const Message& axis) {
  return set ? std::optional<JointAxis>(DecodeAxis(axis)) : std::nullopt;
}

BallJoint DecodeBall(const v1::BallJoint& ball) {
  BallJoint decoded{.swing_max = {}, .twist = DecodeLimits(ball.twist())};
  if (ball.has_swing_max_radians()) decoded.swing_max = ball.swing_max_radians();
  return decoded;
}

WheelJoint DecodeWheel(const v1::WheelJoint& wheel) {
  return {.suspension = DecodeIf(wheel.has_suspension(), wheel.suspension()),
          .steering = DecodeIf(wheel.has_steering(), wheel.steering()),
          .spin = DecodeAxis(wheel.spin())};
}

SixDofJoint DecodeSixDof(const v1::SixDofJoint& joint) {
  return {.along = {DecodeIf(joint.has_along_x(), joint.along_x()), DecodeIf(joint.has_along_y(), joint.along_y()),
                    DecodeIf(joint.has_along_z(), joint.along_z())},
          .about = {DecodeIf(joint.has_about_x(), joint.about_x()), DecodeIf(joint.has_about_y(), joint.about_y()),
                    DecodeIf(joint.has_about_z(), joint.about_z())}};
}

Result<JointKind> DecodeKind(const v1::Joint& joint) {
  switch (joint.kind_case()) {
    case v1::Joint::kBall:
      return DecodeBall(joint.ball());
    case v1::Joint::kHinge:
      return HingeJoint{DecodeAxis(joint.hinge())};
    case v1::Joint::kSlider:
      return SliderJoint{DecodeAxis(joint.slider())};
    case v1::Joint::kUniversal:
      return UniversalJoint{DecodeAxis(joint.universal().about_x()), DecodeAxis(joint.universal().about_y())};
    case v1::Joint::kFixed:
      return FixedJoint{};
    case v1::Joint::kWheel:
      return DecodeWheel(joint.wheel());
    case v1::Joint::kSixDof:
      return DecodeSixDof(joint.six_dof());
    case v1::Joint::kDistance:
      return DistanceJoint{DecodeAxis(joint.distance())};
    case v1::Joint::kGear:
      return GearJoint{joint.gear().has_ratio() ? joint.gear().ratio() : 1};
    case v1::Joint::KIND_NOT_SET:
      break;
  }
  return Refuse(Reason::kMissingField, "kind", "a joint says what it leaves free");
}

EntityRef DecodeRef(const v1::EntityRef& entity) {
  if (entity.has_created_by_command()) return {{}, entity.created_by_command()};
  return {EntityId::FromPacked(entity.id()), {}};
}

}  // namespace

Result<JointDesc> DecodeJoint(const v1::Joint& joint) {
  Result<JointKind> kind = DecodeKind(joint);
  if (!kind.ok()) return kind.status();
  JointDesc decoded{.entity_a = DecodeRef(joint.entity_a()),
                    .entity_b = DecodeRef(joint.entity_b()),
                    .kind = *std::move(kind),
                    .collide_connected = joint.collide_connected()};
  if (joint.has_frame_in_a()) decoded.frame_in_a = DecodePose(joint.frame_in_a());
  if (joint.has_frame_in_b()) decoded.frame_in_b = DecodePose(joint.frame_in_b());
  if (joint.has_break_force()) decoded.break_force = joint.break_force();
  if (joint.has_break_torque()) decoded.break_torque = joint.break_torque();
  return decoded;
}

JointState DecodeJointState(const v1::JointState& state) {
  JointState decoded;
  for (size_t i = 0; i < kJointCoordinates; ++i) {
    const int place = static_cast<int>(i);
    if (place < state.positions_size()) decoded.positions[i] = state.positions(place);
    if (place < state.rates_size()) decoded.rates[i] = state.rates(place);
  }
  decoded.force = DecodeVector(state.force());
  decoded.torque = DecodeVector(state.torque());
  return decoded;
}

}  // namespace genphys

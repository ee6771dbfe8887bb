#include "joints/check_joint.h"

#include <array>
#include <cmath>
#include <numbers>

#include "genphys/limits.h"
#include "model/cat.h"
#include "model/validate.h"

namespace genphys {
namespace {

// By index of the alternative.
constexpr std::array<std::string_view, std::variant_size_v<JointKind>> kKindNames{
    "ball", "hinge", "slider", "universal", "fixed", "wheel", "six_dof", "distance", "gear"};

// What a number along an axis is called, and how large it may be, as against one about an axis.
struct Units {
  std::string_view lower, upper, target, rest, force;
  double position_max;
  double rate_max;
};
constexpr Units kMetres{"limits.lower_metres", "limits.upper_metres", "motor.target_metres", "spring.rest_metres",
                        "motor.force_max",     Limits::kPositionMax,  Limits::kSpeedMax};
constexpr Units kRadians{"limits.lower_radians", "limits.upper_radians", "motor.target_radians", "spring.rest_radians",
                         "motor.torque_max",     Limits::kJointAngleMax, Limits::kSpinMax};

Status CheckLimits(const AxisLimits& limits, const Units& units) {
  const double bound = units.position_max;
  GENPHYS_RETURN_IF_ERROR(CheckNumber(limits.lower.value_or(0), -bound, bound, units.lower));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(limits.upper.value_or(0), -bound, bound, units.upper));
  if (!limits.lower || !limits.upper || *limits.lower <= *limits.upper) return absl::OkStatus();
  return Refuse(Reason::kInvalidValue, units.upper, "the upper limit is below the lower one");
}

Status CheckMotor(const Motor& motor, const Units& units) {
  GENPHYS_RETURN_IF_ERROR(CheckNumber(motor.target_velocity, -units.rate_max, units.rate_max, "motor.target_velocity"));
  GENPHYS_RETURN_IF_ERROR(
      CheckNumber(motor.target_position.value_or(0), -units.position_max, units.position_max, units.target));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(motor.stiffness, 0, Limits::kStiffnessMax, "motor.stiffness"));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(motor.damping, 0, Limits::kStiffnessMax, "motor.damping"));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(motor.force_max.value_or(0), 0, Limits::kForceMax, units.force));
  if (motor.target_position && motor.stiffness == 0) {
    return Refuse(Reason::kInvalidValue, "motor.stiffness", "a motor that drives to a position needs a stiffness");
  }
  if (!motor.target_position && (motor.stiffness != 0 || motor.damping != 0)) {
    return Refuse(Reason::kInvalidValue, units.target,
                  "stiffness and damping are those of a drive to a position, which is not set");
  }
  return absl::OkStatus();
}

Status CheckAxis(const JointAxis& axis, const Units& units, std::string_view name) {
  const auto prefixed = [&](const Status& status) { return name.empty() ? status : WithFieldPrefix(status, name); };
  GENPHYS_RETURN_IF_ERROR(prefixed(CheckLimits(axis.limits, units)));
  if (axis.motor) GENPHYS_RETURN_IF_ERROR(prefixed(CheckMotor(*axis.motor, units)));
  if (!axis.spring) return absl::OkStatus();
  const Spring& spring = *axis.spring;
  GENPHYS_RETURN_IF_ERROR(prefixed(CheckNumber(spring.stiffness, 0, Limits::kStiffnessMax, "spring.stiffness")));
  GENPHYS_RETURN_IF_ERROR(prefixed(CheckNumber(spring.damping, 0, Limits::kStiffnessMax, "spring.damping")));
  return prefixed(CheckNumber(spring.rest, -units.position_max, units.position_max, units.rest));
}

Status CheckOptional(const std::optional<JointAxis>& axis, const Units& units, std::string_view name) {
  return axis ? CheckAxis(*axis, units, name) : absl::OkStatus();
}

struct KindCheck {
  Status operator()(const BallJoint& joint) const {
    GENPHYS_RETURN_IF_ERROR(CheckNumber(joint.swing_max.value_or(0), 0, std::numbers::pi, "swing_max_radians"));
    const Status twist = CheckLimits(joint.twist, kRadians);
    const std::optional<Refusal> refusal = RefusalOf(twist);
    if (!refusal) return twist;
    // A twist has limits alone, so its field is the limits themselves.
    return Refuse(refusal->reason, Cat("twist", refusal->field.substr(refusal->field.find('.'))), MessageOf(twist));
  }
  Status operator()(const HingeJoint& joint) const { return CheckAxis(joint.axis, kRadians, ""); }
  Status operator()(const SliderJoint& joint) const { return CheckAxis(joint.axis, kMetres, ""); }
  Status operator()(const UniversalJoint& joint) const {
    GENPHYS_RETURN_IF_ERROR(CheckAxis(joint.about_x, kRadians, "about_x"));
    return CheckAxis(joint.about_y, kRadians, "about_y");
  }
  Status operator()(const FixedJoint&) const { return absl::OkStatus(); }
  Status operator()(const WheelJoint& joint) const {
    GENPHYS_RETURN_IF_ERROR(CheckOptional(joint.suspension, kMetres, "suspension"));
    GENPHYS_RETURN_IF_ERROR(CheckOptional(joint.steering, kRadians, "steering"));
    return CheckAxis(joint.spin, kRadians, "spin");
  }
  Status operator()(const SixDofJoint& joint) const {
    static constexpr std::array<std::string_view, 3> kAlong{"along_x", "along_y", "along_z"};
    static constexpr std::array<std::string_view, 3> kAbout{"about_x", "about_y", "about_z"};
    for (size_t i = 0; i < 3; ++i) GENPHYS_RETURN_IF_ERROR(CheckOptional(joint.along[i], kMetres, kAlong[i]));
    for (size_t i = 0; i < 3; ++i) GENPHYS_RETURN_IF_ERROR(CheckOptional(joint.about[i], kRadians, kAbout[i]));
    return absl::OkStatus();
  }
  Status operator()(const DistanceJoint& joint) const {
    GENPHYS_RETURN_IF_ERROR(CheckAxis(joint.axis, kMetres, ""));
    if (joint.axis.limits.upper.value_or(0) >= 0) return absl::OkStatus();
    return Refuse(Reason::kOutOfRange, kMetres.upper, "no distance is below zero");
  }
  Status operator()(const GearJoint& joint) const {
    GENPHYS_RETURN_IF_ERROR(CheckNumber(joint.ratio, -Limits::kGearRatioMax, Limits::kGearRatioMax, "ratio"));
    if (joint.ratio == 0) return Refuse(Reason::kInvalidValue, "ratio", "a gear with the ratio zero would only brake");
    if (std::abs(joint.ratio) >= 1 / Limits::kGearRatioMax) return absl::OkStatus();
    return Refuse(Reason::kOutOfRange, "ratio", Cat("must be at least ", 1 / Limits::kGearRatioMax, " off zero"));
  }
};

// The one axis of a hinge or a slider.
JointAxis* OnlyAxis(JointKind& kind) {
  if (HingeJoint* hinge = std::get_if<HingeJoint>(&kind)) return &hinge->axis;
  if (SliderJoint* slider = std::get_if<SliderJoint>(&kind)) return &slider->axis;
  return nullptr;
}

}  // namespace

std::string_view NameOf(const JointKind& kind) { return kKindNames[kind.index()]; }

Status CheckJoint(const JointDesc& joint) {
  if (joint.frame_in_a) GENPHYS_RETURN_IF_ERROR(CheckPose(*joint.frame_in_a, "frame_in_a"));
  if (joint.frame_in_b) GENPHYS_RETURN_IF_ERROR(CheckPose(*joint.frame_in_b, "frame_in_b"));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(std::visit(KindCheck{}, joint.kind), NameOf(joint.kind)));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(joint.break_force.value_or(0), 0, Limits::kForceMax, "break_force"));
  return CheckNumber(joint.break_torque.value_or(0), 0, Limits::kForceMax, "break_torque");
}

Result<JointDesc> Merged(const JointDesc& current, const JointDesc& update, JointFields fields) {
  JointDesc merged = current;
  if (fields.Has(JointField::kFrameInA)) merged.frame_in_a = update.frame_in_a;
  if (fields.Has(JointField::kFrameInB)) merged.frame_in_b = update.frame_in_b;
  if (fields.Has(JointField::kKind)) merged.kind = update.kind;
  if (fields.Has(JointField::kCollideConnected)) merged.collide_connected = update.collide_connected;
  if (fields.Has(JointField::kBreakForce)) merged.break_force = update.break_force;
  if (fields.Has(JointField::kBreakTorque)) merged.break_torque = update.break_torque;
  if (!fields.Has(JointField::kLimits) && !fields.Has(JointField::kMotor) && !fields.Has(JointField::kSpring)) {
    return merged;
  }
  JointKind given = update.kind;
  JointAxis* const to = OnlyAxis(merged.kind);
  const JointAxis* const from = OnlyAxis(given);
  if (to == nullptr || from == nullptr || merged.kind.index() != given.index()) {
    return Refuse(Reason::kInvalidValue, NameOf(update.kind),
                  Cat("the joint is a ", NameOf(current.kind), ": name all of the new kind to change it"));
  }
  if (fields.Has(JointField::kLimits)) to->limits = from->limits;
  if (fields.Has(JointField::kMotor)) to->motor = from->motor;
  if (fields.Has(JointField::kSpring)) to->spring = from->spring;
  return merged;
}

}  // namespace genphys

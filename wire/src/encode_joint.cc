#include <algorithm>
#include <cstring>

#include "genphys/wire/encode.h"
#include "values.h"

namespace genphys {
namespace {

void EncodeLimits(const AxisLimits& limits, v1::AngleLimits* out) {
  if (limits.lower) out->set_lower_radians(*limits.lower);
  if (limits.upper) out->set_upper_radians(*limits.upper);
}

void EncodeLimits(const AxisLimits& limits, v1::DistanceLimits* out) {
  if (limits.lower) out->set_lower_metres(*limits.lower);
  if (limits.upper) out->set_upper_metres(*limits.upper);
}

void EncodeTarget(const Motor& motor, v1::AngularMotor* out) {
  if (motor.target_position) out->set_target_radians(*motor.target_position);
  if (motor.force_max) out->set_torque_max(*motor.force_max);
}

void EncodeTarget(const Motor& motor, v1::LinearMotor* out) {
  if (motor.target_position) out->set_target_metres(*motor.target_position);
  if (motor.force_max) out->set_force_max(*motor.force_max);
}

void EncodeRest(double rest, v1::AngularSpring* out) { out->set_rest_radians(rest); }
void EncodeRest(double rest, v1::LinearSpring* out) { out->set_rest_metres(rest); }

// Of an axis, or of a joint that has one axis and no more.
template <typename Message>
void EncodeAxis(const JointAxis& axis, Message* out) {
  if (axis.limits != AxisLimits{}) EncodeLimits(axis.limits, out->mutable_limits());
  if (axis.motor) {
    auto* const motor = out->mutable_motor();
    motor->set_target_velocity(axis.motor->target_velocity);
    motor->set_stiffness(axis.motor->stiffness);
    motor->set_damping(axis.motor->damping);
    EncodeTarget(*axis.motor, motor);
  }
  if (!axis.spring) return;
  out->mutable_spring()->set_stiffness(axis.spring->stiffness);
  out->mutable_spring()->set_damping(axis.spring->damping);
  EncodeRest(axis.spring->rest, out->mutable_spring());
}

struct KindEncoder {
  v1::Joint* out;

  void operator()(const BallJoint& ball) const {
    v1::BallJoint* const message = out->mutable_ball();
    if (ball.swing_max) message->set_swing_max_radians(*ball.swing_max);
    if (ball.twist != AxisLimits{}) EncodeLimits(ball.twist, message->mutable_twist());
  }
  void operator()(const HingeJoint& hinge) const { EncodeAxis(hinge.axis, out->mutable_hinge()); }
  void operator()(const SliderJoint& slider) const { EncodeAxis(slider.axis, out->mutable_slider()); }
  void operator()(const UniversalJoint& joint) const {
    v1::UniversalJoint* const message = out->mutable_universal();
    if (joint.about_x != JointAxis{}) EncodeAxis(joint.about_x, message->mutable_about_x());
    if (joint.about_y != JointAxis{}) EncodeAxis(joint.about_y, message->mutable_about_y());
  }
  void operator()(const FixedJoint&) const { out->mutable_fixed(); }
  void operator()(const WheelJoint& wheel) const {
    v1::WheelJoint* const message = out->mutable_wheel();
    if (wheel.suspension) EncodeAxis(*wheel.suspension, message->mutable_suspension());
    if (wheel.steering) EncodeAxis(*wheel.steering, message->mutable_steering());
    if (wheel.spin != JointAxis{}) EncodeAxis(wheel.spin, message->mutable_spin());
  }
  void operator()(const SixDofJoint& joint) const {
    v1::SixDofJoint* const message = out->mutable_six_dof();
    if (joint.along[0]) EncodeAxis(*joint.along[0], message->mutable_along_x());
    if (joint.along[1]) EncodeAxis(*joint.along[1], message->mutable_along_y());
    if (joint.along[2]) EncodeAxis(*joint.along[2], message->mutable_along_z());
    if (joint.about[0]) EncodeAxis(*joint.about[0], message->mutable_about_x());
    if (joint.about[1]) EncodeAxis(*joint.about[1], message->mutable_about_y());
    if (joint.about[2]) EncodeAxis(*joint.about[2], message->mutable_about_z());
  }
  void operator()(const DistanceJoint& joint) const { EncodeAxis(joint.axis, out->mutable_distance()); }
  void operator()(const GearJoint& gear) const { out->mutable_gear()->set_ratio(gear.ratio); }
};

void EncodeRef(const EntityRef& entity, v1::EntityRef* out) {
  if (entity.created_by_command) {
    out->set_created_by_command(*entity.created_by_command);
  } else {
    out->set_id(entity.id.packed());
  }
}

template <typename Scalar>
void Append(const double* values, size_t count, std::string* column) {
  for (size_t i = 0; i < count; ++i) {
    const auto scalar = static_cast<Scalar>(values[i]);
    column->append(reinterpret_cast<const char*>(&scalar), sizeof(scalar));
  }
}

template <typename Scalar>
void AppendState(const JointState& state, v1::Frame* out) {
  Append<Scalar>(state.positions.data(), kJointCoordinates, out->mutable_joint_positions());
  Append<Scalar>(state.rates.data(), kJointCoordinates, out->mutable_joint_rates());
  Append<Scalar>(state.force.data(), 3, out->mutable_joint_forces());
  Append<Scalar>(state.torque.data(), 3, out->mutable_joint_forces());
}

}  // namespace

void EncodeJoint(JointId id, const JointDesc& desc, v1::Joint* out) {
  out->set_id(id.packed());
  if (!desc.entity_a.is_world()) EncodeRef(desc.entity_a, out->mutable_entity_a());
  if (!desc.entity_b.is_world()) EncodeRef(desc.entity_b, out->mutable_entity_b());
  if (desc.frame_in_a) EncodePose(*desc.frame_in_a, out->mutable_frame_in_a());
  if (desc.frame_in_b) EncodePose(*desc.frame_in_b, out->mutable_frame_in_b());
  std::visit(KindEncoder{out}, desc.kind);
  out->set_collide_connected(desc.collide_connected);
  if (desc.break_force) out->set_break_force(*desc.break_force);
  if (desc.break_torque) out->set_break_torque(*desc.break_torque);
}

void EncodeJointState(JointId id, const JointState& state, v1::JointState* out) {
  out->set_joint_id(id.packed());
  for (const double position : state.positions) out->add_positions(position);
  for (const double rate : state.rates) out->add_rates(rate);
  EncodeVector(state.force, out->mutable_force());
  EncodeVector(state.torque, out->mutable_torque());
}

void EncodeJointColumns(const World& world, v1::Frame* out) {
  std::vector<JointId> ids;
  for (const std::optional<SceneJoint>& joint : world.scene().joints) {
    if (joint) ids.push_back(joint->id);
  }
  std::sort(ids.begin(), ids.end());
  EncodeColumn(ids, out->mutable_joint_ids());
  for (const JointId id : ids) {
    const JointState state = world.joint_state(id);
    out->scalar() == v1::SCALAR_FLOAT32 ? AppendState<float>(state, out) : AppendState<double>(state, out);
  }
}

}  // namespace genphys

#include "genphys/joint.h"

#include <algorithm>

namespace genphys {
namespace {

struct AxesVisitor {
  std::vector<JointAxis*> axes;

  void Add(std::optional<JointAxis>& axis) {
    if (axis) axes.push_back(&*axis);
  }

  void operator()(BallJoint&) {}
  void operator()(FixedJoint&) {}
  void operator()(GearJoint&) {}
  void operator()(HingeJoint& joint) { axes = {&joint.axis}; }
  void operator()(SliderJoint& joint) { axes = {&joint.axis}; }
  void operator()(DistanceJoint& joint) { axes = {&joint.axis}; }
  void operator()(UniversalJoint& joint) { axes = {&joint.about_x, &joint.about_y}; }
  void operator()(WheelJoint& joint) {
    axes = {&joint.spin};
    Add(joint.steering);
    Add(joint.suspension);
  }
  void operator()(SixDofJoint& joint) {
    for (std::optional<JointAxis>& axis : joint.along) Add(axis);
    for (std::optional<JointAxis>& axis : joint.about) Add(axis);
  }
};

struct LocksVisitor {
  bool operator()(const DistanceJoint& joint) const { return joint.axis.limits.lock(); }
  bool operator()(const SixDofJoint& joint) const {
    const auto is_locked = [](const std::optional<JointAxis>& axis) { return !axis || axis->limits.lock(); };
    return std::ranges::any_of(joint.along, is_locked) || std::ranges::any_of(joint.about, is_locked);
  }
  // All others lock what they are named for.
  template <typename Joint>
  bool operator()(const Joint&) const {
    return true;
  }
};

}  // namespace

std::vector<JointAxis*> AxesOf(JointKind& kind) {
  AxesVisitor visitor;
  std::visit(visitor, kind);
  return std::move(visitor.axes);
}

Motor* FirstMotor(JointKind& kind) {
  for (JointAxis* axis : AxesOf(kind)) {
    if (axis->motor) return &*axis->motor;
  }
  return nullptr;
}

bool LocksAny(const JointKind& kind) { return std::visit(LocksVisitor(), kind); }

bool IsDriven(const JointKind& kind) {
  JointKind copy = kind;
  for (const JointAxis* axis : AxesOf(copy)) {
    if (axis->motor && axis->motor->target_velocity != 0 && axis->motor->force_max != 0) return true;
  }
  return false;
}

}  // namespace genphys

#include "genphys/joint.h"

#include <algorithm>

namespace genphys {
namespace {

// Calls visit(place, axis) for each.
template <typename Visit>
struct AxesVisitor {
  Visit visit;

  void See(uint8_t place, JointAxis& axis) { visit(place, axis); }
  void See(uint8_t place, std::optional<JointAxis>& axis) {
    if (axis) visit(place, *axis);
  }

  void operator()(BallJoint&) {}
  void operator()(FixedJoint&) {}
  void operator()(GearJoint&) {}
  void operator()(HingeJoint& joint) { See(5, joint.axis); }
  void operator()(SliderJoint& joint) { See(2, joint.axis); }
  void operator()(DistanceJoint& joint) { See(0, joint.axis); }
  void operator()(UniversalJoint& joint) {
    See(3, joint.about_x);
    See(4, joint.about_y);
  }
  void operator()(WheelJoint& joint) {
    See(4, joint.spin);
    See(5, joint.steering);
    See(2, joint.suspension);
  }
  void operator()(SixDofJoint& joint) {
    for (uint8_t i = 0; i < 3; ++i) See(i, joint.along[i]);
    for (uint8_t i = 0; i < 3; ++i) See(static_cast<uint8_t>(3 + i), joint.about[i]);
  }
};

template <typename Visit>
void VisitAxes(JointKind& kind, Visit visit) {
  AxesVisitor<Visit> visitor{visit};
  std::visit(visitor, kind);
}

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
  std::vector<JointAxis*> axes;
  VisitAxes(kind, [&](uint8_t, JointAxis& axis) { axes.push_back(&axis); });
  return axes;
}

std::vector<uint8_t> PlacesOf(const JointKind& kind) {
  std::vector<uint8_t> places;
  JointKind copy = kind;
  VisitAxes(copy, [&](uint8_t place, JointAxis&) { places.push_back(place); });
  return places;
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

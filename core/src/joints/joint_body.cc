#include "joints/joint_body.h"

#include <cmath>

namespace genphys {

void JointBody::Return() {
  linear_velocity = linear_given;
  angular_velocity = angular_given + (expected_factor / factor - 1) * angular_kick;
}

void JointBody::Foretell(double time, const Vector3& spin) {
  const double rate = spin.norm();
  const double scale = rate > 0 ? std::sin(rate * time / 2) / rate : 0;
  turn_ahead.w() = std::cos(rate * time / 2);
  turn_ahead.vec() = scale * spin;
  center_ahead = center + time * linear_expected;
}

JointSide JointSide::Now(const JointBody& body, const Pose& frame) {
  JointSide side;
  side.body = &body;
  // Of unit quaternions the product is one within rounding.
  side.frame = {body.pose.position + body.axes * frame.position, body.pose.orientation * frame.orientation};
  return side;
}

JointSide JointSide::Ahead() const {
  JointSide ahead;
  ahead.body = body;
  ahead.frame = {body->center_ahead + body->turn_ahead * (frame.position - body->center),
                 body->turn_ahead * frame.orientation};
  return ahead;
}

}  // namespace genphys

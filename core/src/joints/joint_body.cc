#include "joints/joint_body.h"

namespace genphys {

void JointBody::Return() {
  linear_velocity = linear_given;
  angular_velocity = angular_given + (expected_factor / factor - 1) * angular_kick;
}

void JointBody::Foretell(double time) {
  const double angle = angular_expected.norm() * time;
  turn_ahead = Quaternion::Identity();
  if (angle > 0) turn_ahead = Quaternion(Eigen::AngleAxisd(angle, angular_expected.normalized()));
  center_ahead = center + time * linear_expected;
}

JointSide JointSide::Now(const JointBody& body, const Pose& frame) {
  JointSide side;
  side.body = &body;
  side.frame = {body.pose.position + body.axes * frame.position,
                (body.pose.orientation * frame.orientation).normalized()};
  side.axes = side.frame.orientation.toRotationMatrix();
  return side;
}

JointSide JointSide::Ahead() const {
  JointSide ahead;
  ahead.body = body;
  ahead.frame = {body->center_ahead + body->turn_ahead * (frame.position - body->center),
                 (body->turn_ahead * frame.orientation).normalized()};
  ahead.axes = ahead.frame.orientation.toRotationMatrix();
  return ahead;
}

}  // namespace genphys

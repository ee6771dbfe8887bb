#include <algorithm>
#include <cmath>

#include "joints/kinds.h"

namespace genphys {
namespace {

// The coordinates turn faster and faster as the z axes come to point apart; beyond this they are taken as if they did
// not.
constexpr double kLeastScale = 0.05;

}  // namespace

void WriteRows(const BallJoint& joint, RowWriter& writer) {
  writer.LockPoint();
  if (writer.is_foretelling() && !joint.twist.lock()) return;
  const bool is_free = !joint.swing_max && !joint.twist.lower && !joint.twist.upper;
  // The turn about z that is left when the shortest turn that swings z is taken away.
  const Quaternion turn = writer.Turn();
  const double twisted = 2 * std::atan2(turn.z(), turn.w());
  if (!writer.is_noting() && is_free) return writer.CountTurns(5, twisted);
  const Vector3 z_a = writer.a().axis(2), z_b = writer.b().axis(2);
  const Vector3 across = z_a.cross(z_b);
  const double sine = across.norm(), cosine = z_a.dot(z_b);
  Coordinate swing{.place = 3, .axis = writer.a().axis(0), .position = std::atan2(sine, cosine)};
  if (sine > 1e-12) swing.axis = across / sine;
  JointAxis cone;
  cone.limits.upper = joint.swing_max;
  writer.Drive(swing, cone);

  Coordinate twist{.place = 5, .axis = z_a, .position = twisted};
  const Vector3 between = z_a + z_b;
  if (between.norm() > 1e-9) twist.axis = between.normalized();
  twist.scale = std::max(between.norm() / 2, kLeastScale);
  writer.Drive(twist, {.limits = joint.twist, .motor = {}, .spring = {}});
}

}  // namespace genphys

#include <algorithm>
#include <cmath>

#include "joints/kinds.h"

namespace genphys {

void WriteRows(const WheelJoint& joint, RowWriter& writer) {
  if (joint.suspension) {
    writer.LockAcross();
    writer.Drive(writer.Along(2), *joint.suspension);
  } else {
    writer.LockPoint();
  }
  const Vector3 x_a = writer.a().axis(0), y_a = writer.a().axis(1), z_a = writer.a().axis(2);
  const Vector3 x_b = writer.b().axis(0), y_b = writer.b().axis(1);
  // The axle stays perpendicular to the strut, so that the way ahead is perpendicular to both.
  const Vector3 across = y_b.cross(z_a);
  const double sine = across.norm();
  const Vector3 ahead = sine > 1e-9 ? Vector3(across / sine) : x_a;
  writer.Lock({.place = 3, .axis = -ahead, .position = -std::asin(std::clamp(z_a.dot(y_b), -1.0, 1.0))});
  const Coordinate steering{.place = 5, .axis = z_a, .position = std::atan2(-y_b.dot(x_a), y_b.dot(y_a))};
  if (joint.steering) {
    writer.Drive(steering, *joint.steering);
  } else {
    writer.Lock(steering);
  }
  writer.Drive({.place = 4, .axis = y_b, .position = std::atan2(-x_b.dot(z_a), x_b.dot(ahead))}, joint.spin);
}

}  // namespace genphys

#include <algorithm>
#include <cmath>

#include "joints/kinds.h"

namespace genphys {

void WriteRows(const UniversalJoint& joint, RowWriter& writer) {
  writer.LockPoint();
  const Vector3 x_a = writer.a().axis(0), y_a = writer.a().axis(1), z_a = writer.a().axis(2);
  const Vector3 x_b = writer.b().axis(0), y_b = writer.b().axis(1);
  // The cross of the joint: the arms x of a and y of b, and what is perpendicular to both.
  const Vector3 across = x_a.cross(y_b);
  const double sine = across.norm();
  const Vector3 normal = sine > 1e-9 ? Vector3(across / sine) : z_a;
  writer.Lock({.place = 5, .axis = normal, .position = -std::asin(std::clamp(x_a.dot(y_b), -1.0, 1.0))});
  writer.Drive({.place = 3, .axis = x_a, .position = std::atan2(y_b.dot(z_a), y_b.dot(y_a))}, joint.about_x);
  writer.Drive({.place = 4, .axis = y_b, .position = std::atan2(-x_b.dot(normal), x_b.dot(x_a))}, joint.about_y);
}

}  // namespace genphys

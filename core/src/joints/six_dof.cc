#include <algorithm>
#include <cmath>

#include "joints/kinds.h"

namespace genphys {
namespace {

// Where the second turn reaches a quarter of a circle the first and the third are about the same line; near it they are
// taken as if they were this far apart.
constexpr double kLeastScale = 0.05;

// Turns about x of a, then y so turned, then z of b, each with the line about which it turns alone.
std::array<Coordinate, 3> TurnsOf(const RowWriter& writer) {
  const Matrix3 turn = writer.Turn().toRotationMatrix();
  const double second = std::asin(std::clamp(turn(0, 2), -1.0, 1.0));
  const Vector3 x_a = writer.a().axis(0), z_b = writer.b().axis(2);
  const Vector3 across = z_b.cross(x_a);
  const Vector3 y = across.norm() > 1e-9 ? Vector3(across.normalized()) : writer.b().axis(1);
  const double scale = std::max(std::cos(second), kLeastScale);
  return {
      Coordinate{.place = 3, .axis = y.cross(z_b), .position = std::atan2(-turn(1, 2), turn(2, 2)), .scale = scale},
      Coordinate{.place = 4, .axis = y, .position = second},
      Coordinate{.place = 5, .axis = x_a.cross(y), .position = std::atan2(-turn(0, 1), turn(0, 0)), .scale = scale}};
}

}  // namespace

// What is locked comes first, so that springs find it held.
void WriteRows(const SixDofJoint& joint, RowWriter& writer) {
  const auto is_set = [](const std::optional<JointAxis>& axis) { return axis.has_value(); };
  const bool is_moved = std::ranges::any_of(joint.along, is_set), is_turned = std::ranges::any_of(joint.about, is_set);
  if (!is_moved) writer.LockPoint();
  for (int i = 0; i < 3; ++i) {
    if (is_moved && !joint.along[static_cast<size_t>(i)]) writer.Lock(writer.Along(i));
  }
  const std::array<Coordinate, 3> turns = TurnsOf(writer);
  if (!is_turned) writer.LockOrientation();
  for (size_t i = 0; i < 3; ++i) {
    if (is_turned && !joint.about[i]) writer.Lock(turns[i]);
  }
  for (int i = 0; i < 3; ++i) {
    const std::optional<JointAxis>& axis = joint.along[static_cast<size_t>(i)];
    if (axis) writer.Drive(writer.Along(i), *axis);
  }
  for (size_t i = 0; i < 3; ++i) {
    if (joint.about[i]) writer.Drive(turns[i], *joint.about[i]);
  }
}

}  // namespace genphys

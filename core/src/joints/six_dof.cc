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

void WriteRows(const SixDofJoint& joint, RowWriter& writer) {
  if (!joint.along[0] && !joint.along[1] && !joint.along[2]) {
    writer.LockPoint();
  } else {
    for (int i = 0; i < 3; ++i) {
      const std::optional<JointAxis>& axis = joint.along[static_cast<size_t>(i)];
      axis ? writer.Drive(writer.Along(i), *axis) : writer.Lock(writer.Along(i));
    }
  }
  if (!joint.about[0] && !joint.about[1] && !joint.about[2]) return writer.LockOrientation();
  const std::array<Coordinate, 3> turns = TurnsOf(writer);
  for (size_t i = 0; i < 3; ++i) {
    joint.about[i] ? writer.Drive(turns[i], *joint.about[i]) : writer.Lock(turns[i]);
  }
}

}  // namespace genphys

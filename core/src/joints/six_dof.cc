#include <algorithm>
#include <cmath>
#include <numbers>

#include "joints/kinds.h"

namespace genphys {
namespace {

// Where the second turn reaches a quarter of a circle the first and the third are about the same line; near it they are
// taken as if they were this far apart.
constexpr double kLeastScale = 0.05;
constexpr double kHalfTurn = std::numbers::pi;

// Turns about x of a, then y so turned, then z of b, each with the line about which it turns alone. The same frames are
// also turned by half a circle more about x and z, and about y by what is left of half a circle. Where x or z is
// locked, that of both is meant which is nearer to it, so that y goes as far as it likes.
std::array<Coordinate, 3> TurnsOf(const SixDofJoint& joint, const RowWriter& writer) {
  const Matrix3 turn = writer.Turn().toRotationMatrix();
  double first = std::atan2(-turn(1, 2), turn(2, 2)), third = std::atan2(-turn(0, 1), turn(0, 0));
  double second = std::asin(std::clamp(turn(0, 2), -1.0, 1.0));
  const Vector3 x_a = writer.a().axis(0), z_b = writer.b().axis(2);
  const Vector3 across = z_b.cross(x_a);
  Vector3 y = across.norm() > 1e-9 ? Vector3(across.normalized()) : writer.b().axis(1);
  const double scale = std::max(std::cos(second), kLeastScale);
  const Vector3 about_first = y.cross(z_b), about_third = x_a.cross(y);
  const auto is_far = [](const std::optional<JointAxis>& axis, double position) {
    return !axis && std::abs(position) > kHalfTurn / 2;
  };
  if (is_far(joint.about[0], first) || is_far(joint.about[2], third)) {
    const auto opposite = [](double angle) { return angle > 0 ? angle - kHalfTurn : angle + kHalfTurn; };
    first = opposite(first);
    third = opposite(third);
    second = kHalfTurn - second;
    y = -y;
  }
  return {Coordinate{.place = 3, .axis = about_first, .position = first, .scale = scale},
          Coordinate{.place = 4, .axis = y, .position = second},
          Coordinate{.place = 5, .axis = about_third, .position = third, .scale = scale}};
}

// What turns about one axis alone is a hinge.
void WriteHinge(int i, const JointAxis& axis, RowWriter& writer) {
  const Quaternion turn = writer.Turn();
  const double angle = 2 * std::atan2(turn.vec()[i], turn.w());
  writer.Drive({.place = static_cast<size_t>(3 + i), .axis = writer.a().axis(i), .position = angle}, axis);
}

}  // namespace

// What is locked comes first, so that springs find it held.
void WriteRows(const SixDofJoint& joint, RowWriter& writer) {
  const auto is_set = [](const std::optional<JointAxis>& axis) { return axis.has_value(); };
  const bool is_moved = std::ranges::any_of(joint.along, is_set);
  if (!is_moved) writer.LockPoint();
  for (int i = 0; i < 3; ++i) {
    if (is_moved && !joint.along[static_cast<size_t>(i)]) writer.Lock(writer.Along(i));
  }
  const auto turning = std::ranges::count_if(joint.about, is_set);
  const auto alone = static_cast<int>(std::ranges::find_if(joint.about, is_set) - joint.about.begin());
  std::array<Coordinate, 3> turns;
  if (turning == 0) {
    writer.LockOrientation();
  } else if (turning == 1) {
    writer.LockTilt(alone);
  } else {
    turns = TurnsOf(joint, writer);
    for (size_t i = 0; i < 3; ++i) {
      if (!joint.about[i]) writer.Lock(turns[i]);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const std::optional<JointAxis>& axis = joint.along[static_cast<size_t>(i)];
    if (axis) writer.Drive(writer.Along(i), *axis);
  }
  if (turning == 1) return WriteHinge(alone, *joint.about[static_cast<size_t>(alone)], writer);
  for (size_t i = 0; i < 3; ++i) {
    if (joint.about[i]) writer.Drive(turns[i], *joint.about[i]);
  }
}

}  // namespace genphys

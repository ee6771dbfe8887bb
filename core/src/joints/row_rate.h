#pragma once
#include <cmath>

#include "genphys/joint_row.h"
#include "joints/joint_body.h"

namespace genphys {

/// How a centre of mass moves, and what turns about it.
struct Velocities {
  Vector3 linear = Vector3::Zero();  // m/s
  Vector3 spin = Vector3::Zero();    // rad/s
};

/// It holds whatever that takes.
inline bool IsLocked(const JointRow& row) {
  return !row.is_driven && row.lower == -JointRow::kUnbounded && row.upper == JointRow::kUnbounded;
}
/// It pushes one way only.
inline bool IsLimit(const JointRow& row) { return (row.lower == 0) != (row.upper == 0); }
/// It drives with all that it may.
inline bool IsSpent(const JointRow& row) {
  constexpr double kAll = 1 - 1e-9;
  return row.is_driven && std::abs(row.impulse) >= kAll * row.upper;
}

/// Of the row, m/s or rad/s, while its bodies, where they are, move so.
inline double RateOf(const JointRow& row, const JointBody& a, const Velocities& of_a, const JointBody& b,
                     const Velocities& of_b) {
  if (row.kind == JointRow::Kind::kGeared) return row.axis_b.dot(of_b.spin) + row.axis.dot(of_a.spin);
  if (row.kind == JointRow::Kind::kAngular) return row.axis.dot(of_b.spin - of_a.spin);
  const Vector3 at_a = of_a.linear + of_a.spin.cross(row.point - a.center);
  return row.axis.dot(of_b.linear + of_b.spin.cross(row.point - b.center) - at_a);
}

/// What the row's impulse is on a body with its centre of mass there, of which it is side a (`sign` -1) or b (1): N*s
/// and N*m*s.
inline Velocities ImpulseOf(const JointRow& row, double sign, const Vector3& center) {
  if (row.kind == JointRow::Kind::kGeared) {
    return {Vector3::Zero(), row.impulse * (sign < 0 ? row.axis : row.axis_b)};
  }
  const Vector3 push = sign * row.impulse * row.axis;
  if (row.kind == JointRow::Kind::kAngular) return {Vector3::Zero(), push};
  return {push, (row.point - center).cross(push)};
}

}  // namespace genphys

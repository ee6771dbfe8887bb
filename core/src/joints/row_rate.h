#pragma once
#include "genphys/joint_row.h"
#include "joint_body.h"

namespace genphys {

/// How a centre of mass moves, and what turns about it.
struct Velocities {
  Vector3 linear = Vector3::Zero();  // m/s
  Vector3 spin = Vector3::Zero();    // rad/s
};

/// Of the row, m/s or rad/s, while its bodies, where they are, move so.
inline double RateOf(const JointRow& row, const JointBody& a, const Velocities& of_a, const JointBody& b,
                     const Velocities& of_b) {
  if (row.kind == JointRow::Kind::kGeared) return row.axis_b.dot(of_b.spin) + row.axis.dot(of_a.spin);
  if (row.kind == JointRow::Kind::kAngular) return row.axis.dot(of_b.spin - of_a.spin);
  const Vector3 at_a = of_a.linear + of_a.spin.cross(row.point - a.center);
  return row.axis.dot(of_b.linear + of_b.spin.cross(row.point - b.center) - at_a);
}

}  // namespace genphys

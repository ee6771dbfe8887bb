#include "contacts/solver_rows.h"

#include <algorithm>
#include <limits>

namespace genphys {
namespace {

Eigen::Vector4d PaddedOf(const Vector3& v) { return {v.x(), v.y(), v.z(), 0}; }

// Fills in a Jacobian and what follows from it. Returns the rate before the solve.
double FillJacobian(const Vector3& push, const Vector3& turn_a, const Vector3& turn_b, const SweptBody& a,
                    const SweptBody& b, SolverRow& to) {
  const Vector3 gain_a = a.inverse_tensor * turn_a, gain_b = b.inverse_tensor * turn_b;
  to.push = PaddedOf(push);
  to.turn_a = PaddedOf(turn_a);
  to.turn_b = PaddedOf(turn_b);
  to.gain_a = PaddedOf(gain_a);
  to.gain_b = PaddedOf(gain_b);
  to.mobility = push.dot(push) * (a.inverse_mass + b.inverse_mass) + turn_a.dot(gain_a) + turn_b.dot(gain_b);
  return push.dot(a.linear_velocity - b.linear_velocity) + turn_a.dot(a.angular_velocity) +
         turn_b.dot(b.angular_velocity);
}

}  // namespace

void FillJointRow(const JointRow& row, const SweptBody& a, const SweptBody& b, BoundedRow& to) {
  const Vector3 axis = row.axis, none = Vector3::Zero();
  double rate = 0;
  switch (row.kind) {
    case JointRow::Kind::kLinear: {
      const Vector3& point = row.point;
      rate = FillJacobian(-axis, axis.cross(point - a.center), (point - b.center).cross(axis), a, b, to);
      break;
    }
    case JointRow::Kind::kAngular:
      rate = FillJacobian(none, -axis, axis, a, b, to);
      break;
    case JointRow::Kind::kGeared:
      rate = FillJacobian(none, axis, row.axis_b, a, b, to);
      break;
  }
  to.softness = row.softness;
  to.inverse = 1 / (to.mobility + row.softness);
  to.wanted = (row.target - rate) * to.inverse;
  to.lower = row.lower;
  to.upper = row.upper;
}

double FillPush(const Vector3& axis, const Vector3& place, const SweptBody& a, const SweptBody& b, SolverRow& to) {
  const double rate = FillJacobian(axis, (place - a.center).cross(axis), axis.cross(place - b.center), a, b, to);
  to.inverse = 1 / to.mobility;
  to.wanted = 0;
  return rate;
}

double FillContact(const ContactPoint& point, double rate, const ErrorCorrection& correction, double step_size,
                   SolverRow& to) {
  const double depth = point.depth;
  // A gap may be closed within the step.
  to.wanted = (-rate - point.bend + std::min(depth, 0.0) / step_size) * to.inverse;
  if (depth <= 0) return 0;
  double part = kOverlapTakenPerStep, left = depth;
  if (correction.any()) {
    part = correction.PartOf(step_size, kOverlapTakenPerStep);
    const double speed_max = correction.speed_max.value_or(std::numeric_limits<double>::infinity());
    left = std::clamp(depth - correction.slop.value_or(0), 0.0, speed_max * step_size / part);
  }
  return left * part / step_size * to.inverse;
}

void FindTangents(const Vector3& normal, const Vector3& slip, Vector3& first, Vector3& second) {
  // m/s: slower slip has no direction.
  constexpr double kNoSlip = 1.5e-8;
  const Vector3 along = slip - normal * normal.dot(slip);
  const double speed = along.norm();
  if (speed > kNoSlip) {
    first = along / speed;
  } else if (std::abs(normal.z()) > std::sqrt(0.5)) {
    first = Vector3(0, -normal.z(), normal.y()).normalized();
  } else {
    first = Vector3(-normal.y(), normal.x(), 0).normalized();
  }
  second = first.cross(normal);
}

// With (mobility + shift) impulse = wanted, for the least shift with which the impulse is short enough (Moré and
// Sorensen, SIAM J. Sci. Stat. Comput. 4, 1983).
Eigen::Vector2d NearestInDisc(const Eigen::Matrix2d& mobility, const Eigen::Vector2d& wanted, double most) {
  constexpr int kShiftsMax = 8;
  constexpr double kNear = 1e-6;
  if (!(most > 0)) return Eigen::Vector2d::Zero();
  // So much smaller than what is wanted that mobility is nothing beside the shift, which may be beyond all numbers.
  constexpr double kTiny = 1e-15;
  if (kTiny * wanted.norm() > most * mobility.trace()) return most * wanted.normalized();
  double shift = 0;
  Eigen::Vector2d impulse;
  for (int i = 0; i < kShiftsMax; ++i) {
    const Eigen::Matrix2d inverse = (mobility + shift * Eigen::Matrix2d::Identity()).inverse();
    impulse = inverse * wanted;
    const double length = impulse.norm();
    if (length <= (1 + kNear) * most) break;
    shift += (length / most - 1) * length * length / impulse.dot(inverse * impulse);
  }
  const double length = impulse.norm();
  return length > most ? Eigen::Vector2d(most / length * impulse) : impulse;
}

}  // namespace genphys

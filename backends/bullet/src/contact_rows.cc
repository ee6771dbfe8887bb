#include "contact_rows.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <limits>

namespace genphys::bullet_backend {
namespace {

btVector3 CenterOf(const btSolverBody& body) { return body.m_worldTransform.getOrigin(); }

Eigen::Vector4d Padded(const btVector3& v) { return {v.x(), v.y(), v.z(), 0}; }

// Fills in a Jacobian and what follows from it. Returns the rate before the solve.
double FillJacobian(const btVector3& push, const btVector3& turn_a, const btVector3& turn_b, const btSolverBody& a,
                    const btSolverBody& b, SolverRow& to) {
  const btVector3 gain_a = Turned(a, turn_a), gain_b = Turned(b, turn_b);
  to.push = Padded(push);
  to.turn_a = Padded(turn_a);
  to.turn_b = Padded(turn_b);
  to.gain_a = Padded(gain_a);
  to.gain_b = Padded(gain_b);
  to.mobility = push.dot(push) * (a.internalGetInvMass().x() + b.internalGetInvMass().x()) + turn_a.dot(gain_a) +
                turn_b.dot(gain_b);
  return push.dot(a.m_linearVelocity - b.m_linearVelocity) + turn_a.dot(a.m_angularVelocity) +
         turn_b.dot(b.m_angularVelocity);
}

}  // namespace

btVector3 Turned(const btSolverBody& body, const btVector3& impulse) {
  return body.m_originalBody != nullptr ? body.m_originalBody->getInvInertiaTensorWorld() * impulse
                                        : btVector3(0, 0, 0);
}

void FillJointRow(const JointRow& row, const btSolverBody& a, const btSolverBody& b, BoundedRow& to) {
  const btVector3 axis = ToBullet(row.axis), none(0, 0, 0);
  double rate = 0;
  switch (row.kind) {
    case JointRow::Kind::kLinear: {
      const btVector3 point = ToBullet(row.point);
      rate = FillJacobian(-axis, axis.cross(point - CenterOf(a)), (point - CenterOf(b)).cross(axis), a, b, to);
      break;
    }
    case JointRow::Kind::kAngular:
      rate = FillJacobian(none, -axis, axis, a, b, to);
      break;
    case JointRow::Kind::kGeared:
      rate = FillJacobian(none, axis, ToBullet(row.axis_b), a, b, to);
      break;
  }
  to.softness = row.softness;
  to.inverse = 1 / (to.mobility + row.softness);
  to.wanted = (row.target - rate) * to.inverse;
  to.lower = row.lower;
  to.upper = row.upper;
}

double FillPush(const btVector3& axis, const btVector3& place, const btSolverBody& a, const btSolverBody& b,
                SolverRow& to) {
  const double rate = FillJacobian(axis, (place - CenterOf(a)).cross(axis), axis.cross(place - CenterOf(b)), a, b, to);
  to.inverse = 1 / to.mobility;
  to.wanted = 0;
  return rate;
}

double FillContact(double depth, double rate, const ErrorCorrection& correction, double step_size, SolverRow& to) {
  // A gap may be closed within the step.
  to.wanted = (-rate + std::min(depth, 0.0) / step_size) * to.inverse;
  if (depth <= 0) return 0;
  double part = kOverlapTakenPerStep, left = depth;
  if (correction.any()) {
    part = correction.PartOf(step_size, kOverlapTakenPerStep);
    const double speed_max = correction.speed_max.value_or(std::numeric_limits<double>::infinity());
    left = std::clamp(depth - correction.slop.value_or(0), 0.0, speed_max * step_size / part);
  }
  return left * part / step_size * to.inverse;
}

void FindTangents(const btVector3& normal, const btVector3& slip, btVector3& first, btVector3& second) {
  const btVector3 along = slip - normal * normal.dot(slip);
  if (along.length2() > SIMD_EPSILON) {
    first = along.normalized();
    second = first.cross(normal);
  } else {
    btPlaneSpace1(normal, first, second);
  }
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

}  // namespace genphys::bullet_backend

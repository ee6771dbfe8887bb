#pragma once
#include <BulletDynamics/ConstraintSolver/btSolverBody.h>
#include <BulletDynamics/ConstraintSolver/btSolverConstraint.h>

#include "convert.h"
#include "genphys/error_correction.h"
#include "genphys/joint_row.h"

namespace genphys::bullet_backend {

/// Part of an overlap that one step takes away. It is taken away by moving the bodies apart, never by a velocity, so
/// that it costs no accuracy to be quick.
inline constexpr double kOverlapTakenPerStep = 0.4;

// Rows of Bullet's solver, written from what the layer says of contacts and joints. Bullet's own way there leads
// through manifolds, which are a cache of points and ten times as large as what is to be said of one.

/// The whole of a row of a joint: rate + softness * impulse = target.
void FillJointRow(const JointRow& row, const btSolverBody& a, const btSolverBody& b, btSolverConstraint& to);

/// The Jacobian of a row that pushes `a` along `axis` (unit length) at `place`, and `b` against it. Returns how fast a
/// goes that way against b there, m/s. All else is zero, and without bounds.
double FillPush(const btVector3& axis, const btVector3& place, const btSolverBody& a, const btSolverBody& b,
                btSolverConstraint& to);

/// What remains to be said of a row that keeps two bodies apart, which are `depth` inside each other (negative: a gap)
/// and approach at -`rate` m/s.
void FillContact(double depth, double rate, const ErrorCorrection& correction, double step_size,
                 btSolverConstraint& to);

/// Starts a row from `impulse`.
void StartFrom(double impulse, btSolverBody& a, btSolverBody& b, btSolverConstraint& row);

/// Two directions across `normal`, the first of them along `slip` if there is any.
void FindTangents(const btVector3& normal, const btVector3& slip, btVector3& first, btVector3& second);

/// One turn of a sweep: brings the rate of a row that FillPush() made to what it shall be, as far as the bounds let it.
/// Returns by how much it was off. Of the bodies only what the sweeps change is touched.
inline double Relax(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row, double lower, double upper) {
  btVector3& linear_a = a.internalGetDeltaLinearVelocity();
  btVector3& linear_b = b.internalGetDeltaLinearVelocity();
  btVector3& angular_a = a.internalGetDeltaAngularVelocity();
  btVector3& angular_b = b.internalGetDeltaAngularVelocity();
  const btScalar rate = row.m_contactNormal1.dot(linear_a - linear_b) + row.m_relpos1CrossNormal.dot(angular_a) +
                        row.m_relpos2CrossNormal.dot(angular_b);
  const btScalar before = row.m_appliedImpulse;
  const btScalar after = btMin(btMax(before + row.m_rhs - rate * row.m_jacDiagABInv, lower), upper);
  const btScalar change = after - before;
  row.m_appliedImpulse = after;
  linear_a += row.m_contactNormal1 * (a.internalGetInvMass().x() * change);
  linear_b -= row.m_contactNormal1 * (b.internalGetInvMass().x() * change);
  angular_a += row.m_angularComponentA * change;
  angular_b += row.m_angularComponentB * change;
  return change / row.m_jacDiagABInv;
}

/// The same with what takes an overlap apart by a move, and leaves the velocities as they are.
inline double RelaxPush(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row) {
  btVector3& push_a = a.internalGetPushVelocity();
  btVector3& push_b = b.internalGetPushVelocity();
  btVector3& turn_a = a.internalGetTurnVelocity();
  btVector3& turn_b = b.internalGetTurnVelocity();
  const btScalar rate = row.m_contactNormal1.dot(push_a - push_b) + row.m_relpos1CrossNormal.dot(turn_a) +
                        row.m_relpos2CrossNormal.dot(turn_b);
  const btScalar before = row.m_appliedPushImpulse;
  const btScalar after = btMax(before + row.m_rhsPenetration - rate * row.m_jacDiagABInv, 0.0);
  const btScalar change = after - before;
  row.m_appliedPushImpulse = after;
  push_a += row.m_contactNormal1 * (a.internalGetInvMass().x() * change);
  push_b -= row.m_contactNormal1 * (b.internalGetInvMass().x() * change);
  turn_a += row.m_angularComponentA * change;
  turn_b += row.m_angularComponentB * change;
  return change / row.m_jacDiagABInv;
}

}  // namespace genphys::bullet_backend

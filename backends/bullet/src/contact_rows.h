#pragma once
#include <BulletDynamics/ConstraintSolver/btSolverBody.h>
#include <BulletDynamics/ConstraintSolver/btSolverConstraint.h>

#include <limits>

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

/// The velocities of a body that rows change, of one of the two kinds that the solver keeps.
struct Motion {
  btVector3& linear;
  btVector3& angular;
  btScalar inverse_mass;
};

/// One turn of a row between two motions: `applied` comes as near to `wanted` as its bounds let it. Returns the change
/// of the row's rate.
inline double RelaxMotion(const btSolverConstraint& row, const Motion& a, const Motion& b, double wanted, double lower,
                          double upper, btScalar& applied) {
  const btScalar rate = row.m_contactNormal1.dot(a.linear - b.linear) + row.m_relpos1CrossNormal.dot(a.angular) +
                        row.m_relpos2CrossNormal.dot(b.angular);
  const btScalar before = applied;
  applied = btMin(btMax(before + wanted - rate * row.m_jacDiagABInv, lower), upper);
  const btScalar change = applied - before;
  a.linear += row.m_contactNormal1 * (a.inverse_mass * change);
  b.linear -= row.m_contactNormal1 * (b.inverse_mass * change);
  a.angular += row.m_angularComponentA * change;
  b.angular += row.m_angularComponentB * change;
  return change / row.m_jacDiagABInv;
}

/// One turn of a sweep: brings the rate of a row that FillPush() made to what it shall be, as far as the bounds let it.
/// Returns by how much it was off. Of the bodies only what the sweeps change is touched.
inline double Relax(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row, double lower, double upper) {
  const auto motion = [](btSolverBody& body) {
    return Motion{body.internalGetDeltaLinearVelocity(), body.internalGetDeltaAngularVelocity(),
                  body.internalGetInvMass().x()};
  };
  return RelaxMotion(row, motion(a), motion(b), row.m_rhs, lower, upper, row.m_appliedImpulse);
}

/// The same with what takes an overlap apart by a move, and leaves the velocities as they are.
inline double RelaxPush(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row) {
  const auto motion = [](btSolverBody& body) {
    return Motion{body.internalGetPushVelocity(), body.internalGetTurnVelocity(), body.internalGetInvMass().x()};
  };
  return RelaxMotion(row, motion(a), motion(b), row.m_rhsPenetration, 0, std::numeric_limits<double>::infinity(),
                     row.m_appliedPushImpulse);
}

}  // namespace genphys::bullet_backend

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

/// A row between two bodies that touch: what Bullet's own says of it in little more than half as much memory, through
/// which a sweep of a large pile goes from end to end.
struct ContactRow {
  Vector3 push = Vector3::Zero();    // unit length, on a; on b against it
  Vector3 turn_a = Vector3::Zero();  // of the Jacobian, m
  Vector3 turn_b = Vector3::Zero();
  Vector3 gain_a = Vector3::Zero();  // rad/s per N*s
  Vector3 gain_b = Vector3::Zero();
  double mobility = 0;  // m/s per N*s
  double inverse = 0;   // N*s per m/s
  double wanted = 0;    // N*s, were all else as it is
  double impulse = 0;   // N*s
  double friction = 0;  // of one that takes slip: Coulomb coefficient
  int a = 0;            // of the solver's bodies
  int b = 0;
};

/// What takes an overlap apart by a move, which leaves the velocities as they are.
struct ContactPush {
  int row = 0;        // of the contact, that it goes along
  double wanted = 0;  // as in that
  double impulse = 0;
};

/// Fills in all but ids, friction and impulse of a row that pushes `a` along `axis` (unit length) at `place`, and `b`
/// against it, and wants nothing. Returns how fast a goes that way against b there, m/s.
double FillPush(const btVector3& axis, const btVector3& place, const btSolverBody& a, const btSolverBody& b,
                ContactRow& to);

/// What remains to be said of a row that keeps two bodies apart, which are `depth` inside each other (negative: a gap)
/// and approach at -`rate` m/s. Returns what is wanted of a push that takes them apart; zero if none is.
double FillContact(double depth, double rate, const ErrorCorrection& correction, double step_size, ContactRow& to);

/// Starts a row from `impulse`.
void StartFrom(double impulse, btSolverBody& a, btSolverBody& b, ContactRow& row);

/// Two directions across `normal`, the first of them along `slip` if there is any.
void FindTangents(const btVector3& normal, const btVector3& slip, btVector3& first, btVector3& second);

/// The velocities of a body that rows change, of one of the two kinds that the solver keeps.
struct Motion {
  btVector3& linear;
  btVector3& angular;
  btScalar inverse_mass;
};

inline double Dot(const Vector3& x, const btVector3& y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; }

inline void AddTimes(const Vector3& x, double factor, btVector3& to) {
  for (int i = 0; i < 3; ++i) to[i] += x[i] * factor;
}

/// One turn of a row between two motions: `applied` comes as near to `wanted` as its bounds let it. Returns the change
/// of the row's rate.
[[gnu::always_inline]] inline double RelaxMotion(const ContactRow& row, const Motion& a, const Motion& b, double wanted,
                                                 double lower, double upper, double& applied) {
  const double rate = Dot(row.push, a.linear - b.linear) + Dot(row.turn_a, a.angular) + Dot(row.turn_b, b.angular);
  const double before = applied;
  applied = btMin(btMax(before + wanted - rate * row.inverse, lower), upper);
  const double change = applied - before;
  AddTimes(row.push, a.inverse_mass * change, a.linear);
  AddTimes(row.push, -(b.inverse_mass * change), b.linear);
  AddTimes(row.gain_a, change, a.angular);
  AddTimes(row.gain_b, change, b.angular);
  return change * row.mobility;
}

/// One turn of a sweep: brings the rate of a row to what it shall be, as far as the bounds let it. Returns by how much
/// it was off. Of the bodies only what the sweeps change is touched.
[[gnu::always_inline]] inline double Relax(btSolverBody& a, btSolverBody& b, double lower, double upper,
                                           ContactRow& row) {
  const auto motion = [](btSolverBody& body) {
    return Motion{body.internalGetDeltaLinearVelocity(), body.internalGetDeltaAngularVelocity(),
                  body.internalGetInvMass().x()};
  };
  return RelaxMotion(row, motion(a), motion(b), row.wanted, lower, upper, row.impulse);
}

/// The same of a push along `row`.
inline double RelaxPush(btSolverBody& a, btSolverBody& b, const ContactRow& row, ContactPush& push) {
  const auto motion = [](btSolverBody& body) {
    return Motion{body.internalGetPushVelocity(), body.internalGetTurnVelocity(), body.internalGetInvMass().x()};
  };
  return RelaxMotion(row, motion(a), motion(b), push.wanted, 0, std::numeric_limits<double>::infinity(), push.impulse);
}

}  // namespace genphys::bullet_backend

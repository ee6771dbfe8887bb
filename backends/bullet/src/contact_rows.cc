#include "contact_rows.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <limits>

namespace genphys::bullet_backend {
namespace {

btVector3 CenterOf(const btSolverBody& body) { return body.m_worldTransform.getOrigin(); }

btVector3 Turned(const btSolverBody& body, const btVector3& impulse) {
  return body.m_originalBody != nullptr ? body.m_originalBody->getInvInertiaTensorWorld() * impulse
                                        : btVector3(0, 0, 0);
}

double RateOf(const btSolverConstraint& row, const btSolverBody& a, const btSolverBody& b) {
  return row.m_contactNormal1.dot(a.m_linearVelocity) + row.m_relpos1CrossNormal.dot(a.m_angularVelocity) +
         row.m_contactNormal2.dot(b.m_linearVelocity) + row.m_relpos2CrossNormal.dot(b.m_angularVelocity);
}

}  // namespace

void FillJointRow(const JointRow& row, const btSolverBody& a, const btSolverBody& b, btSolverConstraint& to) {
  const btVector3 axis = ToBullet(row.axis), point = ToBullet(row.point);
  switch (row.kind) {
    case JointRow::Kind::kLinear:
      to.m_contactNormal1 = -axis;
      to.m_contactNormal2 = axis;
      to.m_relpos1CrossNormal = (point - CenterOf(a)).cross(-axis);
      to.m_relpos2CrossNormal = (point - CenterOf(b)).cross(axis);
      break;
    case JointRow::Kind::kAngular:
      to.m_relpos1CrossNormal = -axis;
      to.m_relpos2CrossNormal = axis;
      break;
    case JointRow::Kind::kGeared:
      to.m_relpos1CrossNormal = axis;
      to.m_relpos2CrossNormal = ToBullet(row.axis_b);
      break;
  }
  to.m_angularComponentA = Turned(a, to.m_relpos1CrossNormal);
  to.m_angularComponentB = Turned(b, to.m_relpos2CrossNormal);
  const btScalar mobility = to.m_contactNormal1.dot(to.m_contactNormal1 * a.internalGetInvMass()) +
                            to.m_contactNormal2.dot(to.m_contactNormal2 * b.internalGetInvMass()) +
                            to.m_relpos1CrossNormal.dot(to.m_angularComponentA) +
                            to.m_relpos2CrossNormal.dot(to.m_angularComponentB);
  to.m_jacDiagABInv = 1 / (mobility + row.softness);
  to.m_cfm = row.softness * to.m_jacDiagABInv;
  to.m_rhs = (row.target - RateOf(to, a, b)) * to.m_jacDiagABInv;
  to.m_lowerLimit = row.lower;
  to.m_upperLimit = row.upper;
}

double FillPush(const btVector3& axis, const btVector3& place, const btSolverBody& a, const btSolverBody& b,
                ContactRow& to) {
  const btVector3 turn_a = (place - CenterOf(a)).cross(axis), turn_b = axis.cross(place - CenterOf(b));
  const btVector3 gain_a = Turned(a, turn_a), gain_b = Turned(b, turn_b);
  to.push = FromBullet(axis);
  to.turn_a = FromBullet(turn_a);
  to.turn_b = FromBullet(turn_b);
  to.gain_a = FromBullet(gain_a);
  to.gain_b = FromBullet(gain_b);
  to.mobility = a.internalGetInvMass().x() + b.internalGetInvMass().x() + turn_a.dot(gain_a) + turn_b.dot(gain_b);
  to.inverse = 1 / to.mobility;
  to.wanted = 0;
  return axis.dot(a.m_linearVelocity) + turn_a.dot(a.m_angularVelocity) + (-axis).dot(b.m_linearVelocity) +
         turn_b.dot(b.m_angularVelocity);
}

double FillContact(double depth, double rate, const ErrorCorrection& correction, double step_size, ContactRow& to) {
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

void StartFrom(double impulse, btSolverBody& a, btSolverBody& b, ContactRow& row) {
  row.impulse = impulse;
  const btVector3 push = ToBullet(row.push);
  a.internalApplyImpulse(push * a.internalGetInvMass(), ToBullet(row.gain_a), impulse);
  b.internalApplyImpulse(-push * b.internalGetInvMass(), ToBullet(row.gain_b), impulse);
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

}  // namespace genphys::bullet_backend

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
                btSolverConstraint& to) {
  to.m_contactNormal1 = axis;
  to.m_contactNormal2 = -axis;
  to.m_relpos1CrossNormal = (place - CenterOf(a)).cross(axis);
  to.m_relpos2CrossNormal = axis.cross(place - CenterOf(b));
  to.m_angularComponentA = Turned(a, to.m_relpos1CrossNormal);
  to.m_angularComponentB = Turned(b, to.m_relpos2CrossNormal);
  to.m_jacDiagABInv =
      1 / (a.internalGetInvMass().x() + b.internalGetInvMass().x() +
           to.m_relpos1CrossNormal.dot(to.m_angularComponentA) + to.m_relpos2CrossNormal.dot(to.m_angularComponentB));
  to.m_appliedPushImpulse = to.m_appliedImpulse = 0;
  to.m_friction = to.m_rhs = to.m_cfm = to.m_rhsPenetration = 0;
  to.m_upperLimit = std::numeric_limits<double>::infinity();
  to.m_lowerLimit = -to.m_upperLimit;
  to.m_originalContactPoint = nullptr;
  to.m_overrideNumSolverIterations = -1;
  to.m_frictionIndex = 0;
  return RateOf(to, a, b);
}

void FillContact(double depth, double rate, const ErrorCorrection& correction, double step_size,
                 btSolverConstraint& to) {
  to.m_lowerLimit = 0;
  // A gap may be closed within the step.
  to.m_rhs = (-rate + std::min(depth, 0.0) / step_size) * to.m_jacDiagABInv;
  if (depth <= 0) return;
  double part = kOverlapTakenPerStep, left = depth;
  if (correction.any()) {
    part = correction.PartOf(step_size, kOverlapTakenPerStep);
    const double speed_max = correction.speed_max.value_or(std::numeric_limits<double>::infinity());
    left = std::clamp(depth - correction.slop.value_or(0), 0.0, speed_max * step_size / part);
  }
  to.m_rhsPenetration = left * part / step_size * to.m_jacDiagABInv;
}

void StartFrom(double impulse, btSolverBody& a, btSolverBody& b, btSolverConstraint& row) {
  row.m_appliedImpulse = impulse;
  a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA, impulse);
  b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB, impulse);
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

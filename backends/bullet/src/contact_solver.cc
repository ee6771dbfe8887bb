#include "contact_solver.h"

#include "convert.h"

namespace genphys::bullet_backend {

void ContactSolver::Begin(double step_size, double pull, bool are_few) {
  info_.m_timeStep = step_size;
  sweeps_.Begin(step_size, pull, are_few);
  bodies_.clear();
  pairs_.clear();
  rows_.clear();
}

void ContactSolver::Solve(bool direct) {
  is_direct_ = direct;
  solveGroup(bodies_.data(), static_cast<int>(bodies_.size()), nullptr, 0, nullptr, 0, info_, nullptr, nullptr);
}

void ContactSolver::convertContacts(btPersistentManifold**, int, const btContactSolverInfo& info) {
  for (int i = 0; i < m_tmpSolverBodyPool.size(); ++i) {
    const btSolverBody& body = m_tmpSolverBodyPool[i];
    sweeps_.AddBody({.is_dynamic = !body.internalGetInvMass().isZero(),
                     .inverse_mass = body.internalGetInvMass().x(),
                     .inverse_tensor = FromBullet(body.m_originalBody->getInvInertiaTensorWorld()),
                     .center = FromBullet(body.m_worldTransform.getOrigin()),
                     .linear_velocity = FromBullet(body.m_linearVelocity),
                     .angular_velocity = FromBullet(body.m_angularVelocity)});
  }
  // The first number is that of what cannot be moved.
  const auto number_of = [&](Body* body) -> uint32_t {
    return body == nullptr ? ContactSweeps::kFixed
                           : static_cast<uint32_t>(getOrInitSolverBody(*body->rigid, info.m_timeStep)) + 1;
  };
  for (const AddedPair& added : pairs_) {
    sweeps_.AddPair(number_of(added.a), number_of(added.b), *added.pair, added.points, added.impulses);
  }
  for (const AddedRow& added : rows_) sweeps_.AddRow(number_of(added.a), number_of(added.b), *added.row);
}

btScalar ContactSolver::solveGroupCacheFriendlyIterations(btCollisionObject**, int, btPersistentManifold**, int,
                                                          btTypedConstraint**, int, const btContactSolverInfo&,
                                                          btIDebugDraw*) {
  sweeps_.Solve(is_direct_);
  return 0;
}

btScalar ContactSolver::solveGroupCacheFriendlyFinish(btCollisionObject**, int, const btContactSolverInfo&) {
  for (int i = 0; i < m_tmpSolverBodyPool.size(); ++i) {
    btRigidBody& rigid = *m_tmpSolverBodyPool[i].m_originalBody;
    static_cast<Body*>(rigid.getUserPointer())->solved = sweeps_.body(static_cast<uint32_t>(i) + 1);
    rigid.setCompanionId(-1);
  }
  m_tmpSolverBodyPool.resizeNoInitialize(0);
  return 0;
}

}  // namespace genphys::bullet_backend

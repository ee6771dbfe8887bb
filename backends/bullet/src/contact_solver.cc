#include "contact_solver.h"

#include <algorithm>

namespace genphys::bullet_backend {
namespace {

// Part of an overlap that one step takes away. It is taken away by moving the bodies apart, never by a velocity, so
// that it costs no accuracy to be quick.
constexpr double kOverlapTakenPerStep = 0.4;
// Few points get more iterations than a preset's, for this much work in all: what rests then stays where it is also
// when the impulses to start from are another engine's.
constexpr int kPointUpdates = 2000;
constexpr int kIterationsMax = 100;

}  // namespace

ContactSolver::ContactSolver() : fixed_(0.0, nullptr, nullptr) {
  info_.m_erp2 = kOverlapTakenPerStep;
  info_.m_splitImpulse = 1;
  info_.m_splitImpulsePenetrationThreshold = BT_LARGE_FLOAT;
  info_.m_splitImpulseTurnErp = 1;
  // The points are those of the present poses, and not of a cache that may have grown stale: what was found for them is
  // used in full. The solver then goes on over many steps, and what rests comes to rest to the last digits.
  info_.m_warmstartingFactor = 1;
  info_.m_solverMode = SOLVER_USE_WARMSTARTING;
}

void ContactSolver::Begin(double warm_scale) {
  warm_scale_ = warm_scale;
  bodies_.clear();
  first_manifolds_.clear();
  manifold_count_ = 0;
}

void ContactSolver::AddPair(Body* a, Body* b, std::span<const ContactPoint> points,
                            std::span<const PointImpulse> warm_impulses) {
  first_manifolds_.push_back(manifold_count_);
  for (size_t first = 0; first < points.size(); first += MANIFOLD_CACHE_SIZE) {
    const size_t count = std::min<size_t>(points.size() - first, MANIFOLD_CACHE_SIZE);
    AddManifold(a, b, points.subspan(first, count), warm_impulses.subspan(first, count));
  }
}

void ContactSolver::AddManifold(Body* a, Body* b, std::span<const ContactPoint> points,
                                std::span<const PointImpulse> warm_impulses) {
  if (manifold_count_ == manifolds_.size()) manifolds_.emplace_back();
  btPersistentManifold& manifold = manifolds_[manifold_count_++];
  manifold.setBodies(a != nullptr ? a->rigid.get() : &fixed_, b != nullptr ? b->rigid.get() : &fixed_);
  manifold.setContactProcessingThreshold(kContactGap);
  manifold.setNumContacts(static_cast<int>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) {
    btManifoldPoint& point = manifold.getContactPoint(static_cast<int>(i));
    // Bullet's normal is on b and points to a. Places in the bodies' frames are for its cache only.
    point = btManifoldPoint(btVector3(0, 0, 0), btVector3(0, 0, 0), -ToBullet(points[i].normal), -points[i].depth);
    // Both sides are pushed at the same place, or the pair would gain angular momentum.
    point.m_positionWorldOnA = point.m_positionWorldOnB = ToBullet(points[i].position);
    point.m_combinedFriction = points[i].friction;
    point.m_appliedImpulse = warm_scale_ * warm_impulses[i].normal;
    point.m_userPersistentData = const_cast<PointImpulse*>(&warm_impulses[i]);
  }
}

void ContactSolver::Solve(double step_size) {
  info_.m_timeStep = step_size;
  manifold_pointers_.clear();
  int points = 1;
  for (size_t i = 0; i < manifold_count_; ++i) {
    manifold_pointers_.push_back(&manifolds_[i]);
    points += manifolds_[i].getNumContacts();
  }
  info_.m_numIterations = iterations_;
  if (iterations_ == kPresetIterations) {
    info_.m_numIterations = std::max(kPresetIterations, std::min(kPointUpdates / points, kIterationsMax));
  }
  solveGroup(bodies_.data(), static_cast<int>(bodies_.size()), manifold_pointers_.data(),
             static_cast<int>(manifold_count_), nullptr, 0, info_, nullptr, nullptr);
}

void ContactSolver::convertContacts(btPersistentManifold** manifolds, int count, const btContactSolverInfo& info) {
  btSequentialImpulseConstraintSolver::convertContacts(manifolds, count, info);
  for (int i = 0; i < m_tmpSolverContactFrictionConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverContactFrictionConstraintPool[i];
    const btSolverConstraint& normal = m_tmpSolverContactConstraintPool[row.m_frictionIndex];
    const auto& point = *static_cast<const btManifoldPoint*>(normal.m_originalContactPoint);
    const auto& warm = *static_cast<const PointImpulse*>(point.m_userPersistentData);
    const double wanted = -warm_scale_ * warm.friction.dot(FromBullet(point.m_lateralFrictionDir1));
    const double bound = row.m_friction * normal.m_appliedImpulse;
    row.m_appliedImpulse = std::clamp(wanted, -bound, bound);
    btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
    btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
    a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA,
                           row.m_appliedImpulse);
    b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB,
                           row.m_appliedImpulse);
  }
}

btScalar ContactSolver::solveGroupCacheFriendlyFinish(btCollisionObject**, int, const btContactSolverInfo& info) {
  writeBackContacts(0, m_tmpSolverContactConstraintPool.size(), info);
  for (int i = 0; i < m_tmpSolverBodyPool.size(); ++i) {
    btSolverBody& solved = m_tmpSolverBodyPool[i];
    if (solved.m_originalBody == nullptr) continue;
    Body& body = *static_cast<Body*>(solved.m_originalBody->getUserPointer());
    body.motion.linear_velocity = FromBullet(solved.m_linearVelocity + solved.internalGetDeltaLinearVelocity());
    body.motion.angular_velocity = FromBullet(solved.m_angularVelocity + solved.internalGetDeltaAngularVelocity());
    body.motion.push = FromBullet(solved.internalGetPushVelocity());
    body.motion.turn = FromBullet(solved.internalGetTurnVelocity() * info.m_splitImpulseTurnErp);
    solved.m_originalBody->setCompanionId(-1);
  }
  m_tmpSolverContactConstraintPool.resizeNoInitialize(0);
  m_tmpSolverContactFrictionConstraintPool.resizeNoInitialize(0);
  m_tmpSolverBodyPool.resizeNoInitialize(0);
  return 0;
}

void ContactSolver::TakeImpulses(size_t index, std::span<ContactPoint> points) const {
  for (size_t i = 0; i < points.size(); ++i) {
    const btPersistentManifold& manifold = manifolds_[first_manifolds_[index] + i / MANIFOLD_CACHE_SIZE];
    const btManifoldPoint& point = manifold.getContactPoint(static_cast<int>(i % MANIFOLD_CACHE_SIZE));
    points[i].normal_impulse = point.m_appliedImpulse;
    // The direction is that of the motion of a against b, and a positive impulse along it acts on a.
    points[i].friction_impulse = FromBullet(-point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1);
  }
}

}  // namespace genphys::bullet_backend

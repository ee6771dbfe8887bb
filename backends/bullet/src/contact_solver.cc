#include "contact_solver.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "direct_solve.h"

namespace genphys::bullet_backend {
namespace {

// Part of an overlap that one step takes away. It is taken away by moving the bodies apart, never by a velocity, so
// that it costs no accuracy to be quick.
constexpr double kOverlapTakenPerStep = 0.4;
// Few points get more iterations than a preset's, for this much work in all: what rests then stays where it is also
// when the impulses to start from are another engine's.
constexpr int kPointUpdates = 2000;
constexpr int kIterationsMax = 100;
// Softness of a contact that is solved all at once, of its own mobility: the solver divides by what redundant contacts
// leave over.
constexpr double kDirectSoftness = 1e-7;
// The second lets a point bring directions of friction of its own.
constexpr int kSolverMode = SOLVER_USE_WARMSTARTING | SOLVER_ENABLE_FRICTION_DIRECTION_CACHING;
// rad/s: what turns more slowly has no direction.
constexpr double kNoSpin = 1e-9;

btVector3 VelocityAt(const Body* body, const btVector3& place) {
  if (body == nullptr) return btVector3(0, 0, 0);
  return body->rigid->getVelocityInLocalPoint(place - body->rigid->getWorldTransform().getOrigin());
}

// Friction then works against the slip of the surfaces, and not of the bodies. `run` is of b against a.
void RunSurface(const btVector3& run, const Body* a, const Body* b, btManifoldPoint& point) {
  const btVector3& normal = point.m_normalWorldOnB;
  const btVector3 slip = VelocityAt(a, point.m_positionWorldOnA) - VelocityAt(b, point.m_positionWorldOnB) - run;
  const btVector3 along = slip - normal * normal.dot(slip);
  btPlaneSpace1(normal, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
  if (along.length2() > SIMD_EPSILON) {
    point.m_lateralFrictionDir1 = along.normalized();
    point.m_lateralFrictionDir2 = point.m_lateralFrictionDir1.cross(normal);
  }
  point.m_contactMotion1 = run.dot(point.m_lateralFrictionDir1);
  point.m_contactMotion2 = run.dot(point.m_lateralFrictionDir2);
  point.m_contactPointFlags |= BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED;
}

// What is taken away of an overlap, and how fast. No more of it is told than may be taken away in one step.
void SetCorrection(const ErrorCorrection& correction, double step_size, btManifoldPoint& point) {
  const double depth = -point.getDistance();
  if (depth <= 0) return;
  point.m_contactERP = correction.PartOf(step_size, kOverlapTakenPerStep);
  point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP;
  const double left = std::max(depth - correction.slop.value_or(0), 0.0);
  const double speed_max = correction.speed_max.value_or(std::numeric_limits<double>::infinity());
  point.setDistance(-std::min(left, speed_max * step_size / point.m_contactERP));
}

btVector3 CenterOf(const btSolverBody& body) { return body.m_worldTransform.getOrigin(); }

btVector3 Turned(const btSolverBody& body, const btVector3& impulse) {
  return body.m_originalBody != nullptr ? body.m_originalBody->getInvInertiaTensorWorld() * impulse
                                        : btVector3(0, 0, 0);
}

// The Jacobian of the row, and from it what the sweeps need: rate + softness * impulse = target.
void FillRow(const JointRow& row, const btSolverBody& a, const btSolverBody& b, btSolverConstraint& to) {
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
  const btScalar rate = to.m_contactNormal1.dot(a.m_linearVelocity) + to.m_relpos1CrossNormal.dot(a.m_angularVelocity) +
                        to.m_contactNormal2.dot(b.m_linearVelocity) + to.m_relpos2CrossNormal.dot(b.m_angularVelocity);
  to.m_rhs = (row.target - rate) * to.m_jacDiagABInv;
  to.m_lowerLimit = row.lower;
  to.m_upperLimit = row.upper;
}

}  // namespace

ContactSolver::ContactSolver() : fixed_(0.0, nullptr, nullptr) {
  info_.m_erp2 = kOverlapTakenPerStep;
  info_.m_splitImpulse = 1;
  info_.m_splitImpulsePenetrationThreshold = BT_LARGE_FLOAT;
  info_.m_splitImpulseTurnErp = 1;
  // The points are those of the present poses, and not of a cache that may have grown stale: what was found for them is
  // used in full. The solver then goes on over many steps, and what rests comes to rest to the last digits.
  info_.m_warmstartingFactor = 1;
  info_.m_solverMode = kSolverMode;
}

void ContactSolver::Begin(double step_size, double warm_scale) {
  info_.m_timeStep = step_size;
  warm_scale_ = warm_scale;
  bodies_.clear();
  rows_.clear();
  first_manifolds_.clear();
  first_points_.clear();
  points_.clear();
  manifold_count_ = 0;
}

void ContactSolver::AddPair(Body* a, Body* b, const ContactPair& pair, std::span<const ContactPoint> points,
                            std::span<const PointImpulse> warm_impulses) {
  first_manifolds_.push_back(manifold_count_);
  first_points_.push_back(points_.size());
  for (size_t first = 0; first < points.size(); first += MANIFOLD_CACHE_SIZE) {
    const size_t count = std::min<size_t>(points.size() - first, MANIFOLD_CACHE_SIZE);
    AddManifold(a, b, pair, points.subspan(first, count), warm_impulses.subspan(first, count));
  }
}

void ContactSolver::AddManifold(Body* a, Body* b, const ContactPair& pair, std::span<const ContactPoint> points,
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
    if (pair.correction.any()) SetCorrection(pair.correction, info_.m_timeStep, point);
    if (points[i].is_ahead) {
      // Beyond the threshold the solver passes it over.
      point.m_distance1 = BT_LARGE_FLOAT;
      point.m_appliedImpulse = 0;
    }
    if (!pair.surface_velocity.isZero(0)) RunSurface(ToBullet(pair.surface_velocity), a, b, point);
    point.m_userPersistentData = reinterpret_cast<void*>(points_.size());
    points_.push_back({&warm_impulses[i], pair.material.rolling_friction, pair.material.spinning_friction});
  }
}

void ContactSolver::Solve(bool direct) {
  is_direct_ = direct;
  // Sweeps follow the slip from step to step, so that one direction is enough for them. What is solved all at once is
  // held in both: a wheel that is driven one way would drift the other.
  info_.m_solverMode = kSolverMode | (direct ? SOLVER_USE_2_FRICTION_DIRECTIONS : 0);
  manifold_pointers_.clear();
  int points = 1 + static_cast<int>(rows_.size());
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

int ContactSolver::SolverBodyOf(Body* body, double step_size) {
  return getOrInitSolverBody(body != nullptr ? *body->rigid : fixed_, step_size);
}

void ContactSolver::convertJoints(btTypedConstraint**, int, const btContactSolverInfo& info) {
  for (const AddedRow& added : rows_) {
    const int id_a = SolverBodyOf(added.a, info.m_timeStep), id_b = SolverBodyOf(added.b, info.m_timeStep);
    btSolverConstraint& to = m_tmpSolverNonContactConstraintPool.expandNonInitializing();
    std::memset(static_cast<void*>(&to), 0, sizeof(to));
    to.m_solverBodyIdA = id_a;
    to.m_solverBodyIdB = id_b;
    to.m_overrideNumSolverIterations = info.m_numIterations;
    FillRow(*added.row, m_tmpSolverBodyPool[id_a], m_tmpSolverBodyPool[id_b], to);
  }
}

void ContactSolver::convertContacts(btPersistentManifold** manifolds, int count, const btContactSolverInfo& info) {
  btSequentialImpulseConstraintSolver::convertContacts(manifolds, count, info);
  StartFriction();
  AddTorsions();
}

ContactSolver::AddedPoint& ContactSolver::AddedAs(const btSolverConstraint& normal) {
  const auto& point = *static_cast<const btManifoldPoint*>(normal.m_originalContactPoint);
  return points_[reinterpret_cast<size_t>(point.m_userPersistentData)];
}

void ContactSolver::StartFriction() {
  for (int i = 0; i < m_tmpSolverContactFrictionConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverContactFrictionConstraintPool[i];
    const btSolverConstraint& normal = m_tmpSolverContactConstraintPool[row.m_frictionIndex];
    const auto& point = *static_cast<const btManifoldPoint*>(normal.m_originalContactPoint);
    const PointImpulse& warm = *AddedAs(normal).warm;
    const bool is_second = is_direct_ && i % 2 == 1;
    const btVector3& direction = is_second ? point.m_lateralFrictionDir2 : point.m_lateralFrictionDir1;
    const double wanted = -warm_scale_ * warm.friction.dot(FromBullet(direction));
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

void ContactSolver::AddTorsions() {
  torsions_.resizeNoInitialize(0);
  for (int i = 0; i < m_tmpSolverContactConstraintPool.size(); ++i) {
    const btSolverConstraint& normal = m_tmpSolverContactConstraintPool[i];
    const AddedPoint& added = AddedAs(normal);
    if (added.rolling_friction == 0 && added.spinning_friction == 0) continue;
    const auto& point = *static_cast<const btManifoldPoint*>(normal.m_originalContactPoint);
    const Vector3 axis = FromBullet(point.m_normalWorldOnB);
    if (added.spinning_friction > 0) AddTorsion(i, axis, added.spinning_friction);
    if (added.rolling_friction == 0) continue;
    // The bound is one of each axis alone: along the rolling it is the same whatever way that goes.
    const Vector3 spin = FromBullet(m_tmpSolverBodyPool[normal.m_solverBodyIdB].m_angularVelocity -
                                    m_tmpSolverBodyPool[normal.m_solverBodyIdA].m_angularVelocity);
    const Vector3 across = spin - axis * axis.dot(spin);
    const double speed = across.norm();
    const Vector3 first = speed > kNoSpin ? Vector3(across / speed) : axis.unitOrthogonal();
    AddTorsion(i, first, added.rolling_friction);
    AddTorsion(i, axis.cross(first), added.rolling_friction);
  }
}

void ContactSolver::AddTorsion(int normal_index, const Vector3& axis, double arm) {
  const btSolverConstraint& normal = m_tmpSolverContactConstraintPool[normal_index];
  btSolverBody& a = m_tmpSolverBodyPool[normal.m_solverBodyIdA];
  btSolverBody& b = m_tmpSolverBodyPool[normal.m_solverBodyIdB];
  btSolverConstraint& to = torsions_.expandNonInitializing();
  std::memset(static_cast<void*>(&to), 0, sizeof(to));
  to.m_solverBodyIdA = normal.m_solverBodyIdA;
  to.m_solverBodyIdB = normal.m_solverBodyIdB;
  to.m_frictionIndex = normal_index;
  to.m_friction = arm;
  FillRow({.kind = JointRow::Kind::kAngular, .axis = axis}, a, b, to);
  const double bound = arm * normal.m_appliedImpulse;
  to.m_appliedImpulse = std::clamp(warm_scale_ * AddedAs(normal).warm->torque.dot(axis), -bound, bound);
  a.internalApplyImpulse(btVector3(0, 0, 0), to.m_angularComponentA, to.m_appliedImpulse);
  b.internalApplyImpulse(btVector3(0, 0, 0), to.m_angularComponentB, to.m_appliedImpulse);
}

btScalar ContactSolver::solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                             btPersistentManifold** manifolds, int manifold_count,
                                             btTypedConstraint** constraints, int constraint_count,
                                             const btContactSolverInfo& info, btIDebugDraw* drawer) {
  btScalar residual = btSequentialImpulseConstraintSolver::solveSingleIteration(
      iteration, bodies, body_count, manifolds, manifold_count, constraints, constraint_count, info, drawer);
  // The engine passes over the friction of a contact that does not press, with what it was started from still in it.
  for (int i = 0; i < m_tmpSolverContactFrictionConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverContactFrictionConstraintPool[i];
    if (row.m_appliedImpulse == 0 || m_tmpSolverContactConstraintPool[row.m_frictionIndex].m_appliedImpulse > 0)
      continue;
    row.m_lowerLimit = row.m_upperLimit = 0;
    resolveSingleConstraintRowGeneric(m_tmpSolverBodyPool[row.m_solverBodyIdA],
                                      m_tmpSolverBodyPool[row.m_solverBodyIdB], row);
  }
  for (int i = 0; i < torsions_.size(); ++i) {
    btSolverConstraint& row = torsions_[i];
    row.m_upperLimit = row.m_friction * m_tmpSolverContactConstraintPool[row.m_frictionIndex].m_appliedImpulse;
    row.m_lowerLimit = -row.m_upperLimit;
    const btScalar lacked = resolveSingleConstraintRowGeneric(m_tmpSolverBodyPool[row.m_solverBodyIdA],
                                                              m_tmpSolverBodyPool[row.m_solverBodyIdB], row);
    residual = std::max(residual, lacked * lacked);
  }
  return residual;
}

btScalar ContactSolver::solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int body_count,
                                                          btPersistentManifold** manifolds, int manifold_count,
                                                          btTypedConstraint** constraints, int constraint_count,
                                                          const btContactSolverInfo& info, btIDebugDraw* drawer) {
  if (is_direct_ && SolveDirectly()) {
    solveGroupCacheFriendlySplitImpulseIterations(bodies, body_count, manifolds, manifold_count, constraints,
                                                  constraint_count, info, drawer);
    return 0;
  }
  return btSequentialImpulseConstraintSolver::solveGroupCacheFriendlyIterations(
      bodies, body_count, manifolds, manifold_count, constraints, constraint_count, info, drawer);
}

bool ContactSolver::SolveDirectly() {
  DirectSolve solve(m_tmpSolverBodyPool);
  for (int i = 0; i < m_tmpSolverNonContactConstraintPool.size(); ++i) {
    solve.Add(m_tmpSolverNonContactConstraintPool[i], DirectSolve::kFree, 0);
  }
  const int first_contact = m_tmpSolverNonContactConstraintPool.size();
  for (int i = 0; i < m_tmpSolverContactConstraintPool.size(); ++i) {
    solve.Add(m_tmpSolverContactConstraintPool[i], DirectSolve::kFree, kDirectSoftness);
  }
  for (int i = 0; i < m_tmpSolverContactFrictionConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverContactFrictionConstraintPool[i];
    row.m_lowerLimit = -row.m_friction;
    row.m_upperLimit = row.m_friction;
    solve.Add(row, first_contact + row.m_frictionIndex, kDirectSoftness);
  }
  for (int i = 0; i < torsions_.size(); ++i) {
    btSolverConstraint& row = torsions_[i];
    row.m_lowerLimit = -row.m_friction;
    row.m_upperLimit = row.m_friction;
    solve.Add(row, first_contact + row.m_frictionIndex, kDirectSoftness);
  }
  return solve.Run();
}

btScalar ContactSolver::solveGroupCacheFriendlyFinish(btCollisionObject**, int, const btContactSolverInfo& info) {
  for (size_t i = 0; i < rows_.size(); ++i) {
    rows_[i].row->impulse = m_tmpSolverNonContactConstraintPool[static_cast<int>(i)].m_appliedImpulse;
  }
  for (int i = 0; i < torsions_.size(); ++i) {
    const btSolverConstraint& row = torsions_[i];
    AddedAs(m_tmpSolverContactConstraintPool[row.m_frictionIndex]).torque +=
        row.m_appliedImpulse * FromBullet(row.m_relpos2CrossNormal);
  }
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
  m_tmpSolverNonContactConstraintPool.resizeNoInitialize(0);
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
    if (!is_direct_) continue;
    points[i].friction_impulse -= FromBullet(point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2);
  }
}

}  // namespace genphys::bullet_backend

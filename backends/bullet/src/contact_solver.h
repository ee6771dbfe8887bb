#pragma once
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <vector>

#include "body.h"
#include "genphys/contact.h"
#include "genphys/joint_row.h"
#include "warm_start.h"

namespace genphys::bullet_backend {

/// Bullet's sequential impulse solver for contacts and joints between bodies. All of a step form one group: what its
/// rows do to each other is the same as if every island were solved alone, and so is the result.
class ContactSolver final : private btSequentialImpulseConstraintSolver {
 public:
  ContactSolver();

  /// The iterations of every preset.
  static constexpr int kPresetIterations = 10;

  /// Few contacts get more than a preset's.
  void SetIterations(uint32_t iterations) { iterations_ = static_cast<int>(iterations); }

  /// Empties the group, which will be solved for a step of `step_size` seconds. Impulses to start from are multiplied
  /// by `warm_scale`.
  void Begin(double step_size, double warm_scale);

  /// Adds a body, dynamic or kinematic, whose `rigid` is loaded. Each one that a pair names must be added, and once.
  void AddBody(Body& body) { bodies_.push_back(body.rigid.get()); }

  /// Adds a pair; null is a side that cannot be moved. The first of `warm_impulses` are where its points start from.
  void AddPair(Body* a, Body* b, const ContactPair& pair, std::span<const ContactPoint> points,
               std::span<const PointImpulse> warm_impulses);

  /// Adds a row of a joint; null is a side that cannot be moved and stands still. Solve() writes its
  /// impulse back.
  void AddRow(Body* a, Body* b, JointRow& row) { rows_.push_back({a, b, &row}); }

  bool is_empty() const { return manifold_count_ == 0 && rows_.empty(); }

  /// Solves and writes what came out into the bodies' `motion`. All at once, if it shall be `direct` and the equations
  /// let it; else in sweeps.
  void Solve(bool direct);

  /// Fills the impulses of the points of the pair that was added as number `index`.
  void TakeImpulses(size_t index, std::span<ContactPoint> points) const;

  /// What resisted rolling and spinning at a point of that pair, N*m*s on b, world.
  const Vector3& torque(size_t index, size_t point) const { return points_[first_points_[index] + point].torque; }

  BT_DECLARE_ALIGNED_ALLOCATOR();

 private:
  // Bullet's manifolds hold four points, and a pair with a mesh may have more.
  void AddManifold(Body* a, Body* b, const ContactPair& pair, std::span<const ContactPoint> points,
                   std::span<const PointImpulse> warm_impulses);
  // Replaces Bullet's: rows come as the layer writes them.
  void convertJoints(btTypedConstraint** constraints, int count, const btContactSolverInfo& info) override;
  // Adds to Bullet's that friction also starts from what it was.
  void convertContacts(btPersistentManifold** manifolds, int count, const btContactSolverInfo& info) override;
  // Adds to Bullet's what resists rolling and spinning.
  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                btPersistentManifold** manifolds, int manifold_count, btTypedConstraint** constraints,
                                int constraint_count, const btContactSolverInfo& info, btIDebugDraw* drawer) override;
  btScalar solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int body_count,
                                             btPersistentManifold** manifolds, int manifold_count,
                                             btTypedConstraint** constraints, int constraint_count,
                                             const btContactSolverInfo& info, btIDebugDraw* drawer) override;
  // Replaces Bullet's, which would also move the bodies, in its own way.
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                         const btContactSolverInfo& info) override;

  struct AddedRow {
    Body* a;
    Body* b;
    JointRow* row;
  };
  struct AddedPoint {
    const PointImpulse* warm;
    double rolling_friction;  // m
    double spinning_friction;
    Vector3 torque = Vector3::Zero();  // N*m*s on b, found
  };
  int SolverBodyOf(Body* body, double step_size);
  AddedPoint& AddedAs(const btSolverConstraint& normal);
  void StartFriction();
  void AddTorsions();
  void AddTorsion(int normal, const Vector3& axis, double arm);

  // False if the equations cannot be solved all at once.
  bool SolveDirectly();

  int iterations_ = kPresetIterations;
  btContactSolverInfo info_;
  double warm_scale_ = 1;
  btRigidBody fixed_;
  std::vector<btCollisionObject*> bodies_;
  std::vector<size_t> first_manifolds_;  // by pair
  // Kept from step to step for their memory; the first manifold_count_ are in use.
  std::vector<btPersistentManifold> manifolds_;
  std::vector<btPersistentManifold*> manifold_pointers_;
  size_t manifold_count_ = 0;
  std::vector<AddedRow> rows_;
  std::vector<AddedPoint> points_;
  std::vector<size_t> first_points_;  // by pair
  // Rows about lines: m_friction is how far they reach, m and m_frictionIndex the normal whose impulse bounds them.
  btConstraintArray torsions_;
  bool is_direct_ = false;
};

}  // namespace genphys::bullet_backend

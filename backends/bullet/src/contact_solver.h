#pragma once
#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

#include <span>
#include <vector>

#include "body.h"
#include "genphys/contact_sweeps.h"

namespace genphys::bullet_backend {

/// Bullet's sequential impulse solver for the bodies of one island. It keeps the bodies; rows and sweeps are those of
/// the layer.
class ContactSolver final : private btSequentialImpulseConstraintSolver {
 public:
  /// See ContactSweeps.
  void SetIterations(uint32_t iterations) { sweeps_.SetIterations(iterations); }
  void Begin(double step_size, double pull, bool are_few);

  /// Adds a body, dynamic or kinematic, whose `rigid` is loaded. Each one that a pair or a row names must be added, and
  /// once.
  void AddBody(Body& body) { bodies_.push_back(body.rigid.get()); }

  /// Adds a pair; null is a side that cannot be moved. See ContactSweeps.
  void AddPair(Body* a, Body* b, const ContactPair& pair, std::span<ContactPoint> points,
               std::span<PointImpulse> impulses) {
    pairs_.push_back({a, b, &pair, points, impulses});
  }

  /// Adds a row of a joint; null is a side that cannot be moved and stands still.
  void AddRow(Body* a, Body* b, JointRow& row) { rows_.push_back({a, b, &row}); }

  /// Solves and writes what came out into the bodies, contacts, impulses and rows.
  void Solve(bool direct);

  BT_DECLARE_ALIGNED_ALLOCATOR();

 private:
  // Replaces Bullet's: rows are those of the layer.
  void convertJoints(btTypedConstraint**, int, const btContactSolverInfo&) override {}
  void convertContacts(btPersistentManifold**, int, const btContactSolverInfo& info) override;
  // Replaces Bullet's, which passes over the friction of a contact that does not press, with what it was started from
  // still in it, goes through all rows alike, and knows none about lines.
  btScalar solveGroupCacheFriendlyIterations(btCollisionObject**, int, btPersistentManifold**, int, btTypedConstraint**,
                                             int, const btContactSolverInfo&, btIDebugDraw*) override;
  // Replaces Bullet's, which would also move the bodies, in its own way.
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject**, int, const btContactSolverInfo&) override;

  struct AddedPair {
    Body* a;
    Body* b;
    const ContactPair* pair;
    std::span<ContactPoint> points;
    std::span<PointImpulse> impulses;
  };
  struct AddedRow {
    Body* a;
    Body* b;
    JointRow* row;
  };

  ContactSweeps sweeps_;
  btContactSolverInfo info_;
  std::vector<btCollisionObject*> bodies_;
  std::vector<AddedPair> pairs_;
  std::vector<AddedRow> rows_;
  bool is_direct_ = false;
};

}  // namespace genphys::bullet_backend

#pragma once
#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <vector>

#include "body.h"
#include "contact_rows.h"
#include "genphys/contact.h"
#include "genphys/joint_row.h"
#include "genphys/leaps.h"
#include "grips.h"
#include "stirred.h"
#include "warm_start.h"

namespace genphys::bullet_backend {

/// Bullet's sequential impulse solver for contacts and joints between the bodies of one island: how often it sweeps,
/// and in which order, must not depend on what is elsewhere.
class ContactSolver final : private btSequentialImpulseConstraintSolver {
 public:
  ContactSolver();

  /// The iterations of every preset.
  static constexpr int kPresetIterations = 10;
  /// Few points get more iterations than a preset's, for this much work: what rests then stays where it is also
  /// when the impulses to start from are another engine's.
  static constexpr size_t kPointUpdates = 2000;
  /// Points that get more than that.
  static constexpr size_t kFewPoints = kPointUpdates / kPresetIterations;

  /// Few contacts get more than a preset's.
  void SetIterations(uint32_t iterations) { iterations_ = static_cast<int>(iterations); }

  /// Starts with nothing, which will be solved for a step of `step_size` seconds; `pull` as in ContactBuffer. With
  /// `are_few` there will be no more than kFewPoints points and no joints.
  void Begin(double step_size, double pull, bool are_few);

  /// Adds a body, dynamic or kinematic, whose `rigid` is loaded. Each one that a pair names must be added, and once.
  void AddBody(Body& body) { bodies_.push_back(body.rigid.get()); }

  /// Adds a pair; null is a side that cannot be moved. `impulses` are where its points start from; Solve() writes what
  /// they came to into both. All that is given here must last until then.
  void AddPair(Body* a, Body* b, const ContactPair& pair, std::span<ContactPoint> points,
               std::span<PointImpulse> impulses);

  /// Adds a row of a joint; null is a side that cannot be moved and stands still. Solve() writes its
  /// impulse back.
  void AddRow(Body* a, Body* b, JointRow& row) { rows_.push_back({a, b, &row}); }

  /// Solves and writes what came out into the bodies' `motion`. All at once, if it shall be `direct` and the equations
  /// let it; else in sweeps.
  void Solve(bool direct);

  BT_DECLARE_ALIGNED_ALLOCATOR();

 private:
  // Replaces Bullet's: rows come as the layer writes them.
  void convertJoints(btTypedConstraint** constraints, int count, const btContactSolverInfo& info) override;
  // Replaces Bullet's: rows are written from the points. Friction also starts from what it was, and there are rows that
  // resist rolling and spinning.
  void convertContacts(btPersistentManifold** manifolds, int count, const btContactSolverInfo& info) override;
  // Replaces Bullet's, which passes over the friction of a contact that does not press, with what it was started from
  // still in it, goes through all rows alike, and knows none about lines.
  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                btPersistentManifold** manifolds, int manifold_count, btTypedConstraint** constraints,
                                int constraint_count, const btContactSolverInfo& info, btIDebugDraw* drawer) override;
  btScalar solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int body_count,
                                             btPersistentManifold** manifolds, int manifold_count,
                                             btTypedConstraint** constraints, int constraint_count,
                                             const btContactSolverInfo& info, btIDebugDraw* drawer) override;
  // Replaces Bullet's: contacts are no rows of its own.
  void solveGroupCacheFriendlySplitImpulseIterations(btCollisionObject** bodies, int body_count,
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
    ContactPoint* point;
    PointImpulse* impulse;
    double rolling_friction;  // m
    double spinning_friction;
    int first_friction;  // of its rows of friction
    int end_friction;
  };
  // Against turning about a line.
  struct Torsion : BoundedRow {
    int normal = 0;                // the row of the contact whose impulse bounds it
    double arm = 0;                // m, by how much
    bool is_first_of_two = false;  // about lines across each other, bounded together
  };
  int SolverBodyOf(Body* body, double step_size);
  // Where friction works on a point, and how.
  struct Surface {
    btVector3 place;
    btVector3 run;    // m/s, over the bodies
    double pressing;  // N*s, from which a solve starts
    double friction;  // Coulomb coefficient
  };
  // Fills in going_on_ if there are few.
  void FindGoingOn(double step_size);
  // m/s, of a over b, of going_on_.
  btVector3 SlipGoingOn(int a, int b, const btVector3& place) const;
  // Whether one of the two goes along their surfaces before the solve.
  bool GoesAlong(const ContactPoint& point, int id_a, int id_b) const;
  void AddPoint(int id_a, int id_b, const AddedPair& added, size_t number, const Grip& grip);
  // Of the last point.
  void AddFrictions(const AddedPair& added, size_t number, const Grip& grip);
  void AddFriction(const btVector3& direction, const Surface& surface);
  void AddTorsions();
  Torsion& AddTorsion(int normal, const Vector3& axis, double arm);
  // One turn of a row in a sweep. Returns the change of its rate.
  double Resolve(SolverRow& row, double wanted, double lower, double upper) {
    return Relax(row, wanted, lower, upper, row.impulse, ChangeOf(row.a), ChangeOf(row.b));
  }
  double Resolve(BoundedRow& row) {
    return Resolve(row, row.wanted - row.softness * row.inverse * row.impulse, row.lower, row.upper);
  }
  // Starts a row from `impulse`.
  void StartFrom(double impulse, SolverRow& row) {
    row.impulse = impulse;
    Apply(row, impulse, ChangeOf(row.a), ChangeOf(row.b));
  }
  btSolverBody& BodyAt(int id) { return m_tmpSolverBodyPool[id]; }
  MotionChange& ChangeOf(int id) { return changes_[static_cast<size_t>(id)]; }
  void TakeImpulses();
  // Calls visit(row, lower, upper) with each row of a contact, and its bounds.
  template <typename Visit>
  void VisitRows(Visit visit);
  // After a sweep. False if no sweep will come nearer.
  bool Leap();

  // False if the equations cannot be solved all at once.
  bool SolveDirectly();
  // Pushes overlapping bodies apart, all at once; done as well if nothing is pushed faster than `settled` m/s. False as
  // above.
  bool PushDirectly(double settled);

  double pull_ = 0;  // m/s^2, of gravity
  int iterations_ = kPresetIterations;
  btContactSolverInfo info_;
  btRigidBody fixed_;
  std::vector<btCollisionObject*> bodies_;
  std::vector<AddedRow> rows_;
  std::vector<AddedPair> pairs_;
  Grips grips_;  // of pairs_
  // By body of Bullet's pool, in place of what it would change there itself.
  std::vector<MotionChange> changes_;   // of velocities
  std::vector<MotionChange> going_on_;  // velocities, were all points to push and brake as in the last step
  std::vector<MotionChange> moves_;     // velocities that only take overlaps apart
  std::vector<AddedPoint> points_;      // by row of their normal
  size_t point_count_ = 0;              // of pairs_
  bool are_few_ = false;                // see Begin(); of other iterations than a preset's none are
  bool goes_along_ = false;             // of few something GoesAlong()
  std::vector<SolverRow> normals_;
  std::vector<SolverRow> frictions_;
  std::vector<ContactPush> pushes_;  // of normals_, ascending
  Stirred stirred_;
  Leaps leaps_;
  Stirred pushed_;                  // the same of overlaps
  std::vector<BoundedRow> joints_;  // parallel to rows_
  std::vector<Torsion> torsions_;
  bool is_direct_ = false;
  size_t turns_ = 0;  // of points and rows of joints, in the last sweep
};

}  // namespace genphys::bullet_backend

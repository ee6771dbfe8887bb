#pragma once
#include <vector>

#include "contacts/direct_solve.h"
#include "contacts/grips.h"
#include "contacts/leaps.h"
#include "contacts/solver_rows.h"
#include "contacts/stirred.h"
#include "genphys/contact_sweeps.h"

namespace genphys {

/// See ContactSweeps, whose methods these are.
class ContactSweeps::Impl {
 public:
  void SetIterations(uint32_t iterations, bool may_go_on) {
    iterations_ = iterations;
    may_go_on_ = may_go_on;
  }
  void Begin(double step_size, double pull, bool are_few);
  uint32_t AddBody(const SweptBody& body);
  void AddPair(const AddedPair& pair);
  void AddRow(uint32_t a, uint32_t b, JointRow& row);
  void Solve();
  bool SolveDirectly(BoundedSolver* bounded, bool may_sweep);
  const SweptBody& body(uint32_t number) const { return bodies_[number]; }

 private:
  struct AddedRow {
    uint32_t a;
    uint32_t b;
    JointRow* row;
  };
  struct AddedPoint {
    const ContactPair* pair;
    ContactPoint* point;
    PointImpulse* impulse;
    uint32_t first_friction;  // of its rows of friction
    uint32_t end_friction;
  };
  // Against turning about a line.
  struct Torsion : BoundedRow {
    uint32_t normal = 0;           // the row of the contact whose impulse bounds it
    double arm = 0;                // m, by how much
    bool is_first_of_two = false;  // about lines across each other, bounded together
  };
  // Where friction works on a point, and how.
  struct Surface {
    Vector3 place;
    Vector3 run;      // m/s, over the bodies
    double pressing;  // N*s, from which a solve starts
    double friction;  // Coulomb coefficient
  };

  // Of all that was added, for a solve that is `direct` or not.
  void WriteRows(bool direct);
  // Fills in going_on_ if there are few.
  void FindGoingOn();
  // m/s, of a over b, of going_on_.
  Vector3 SlipGoingOn(uint32_t a, uint32_t b, const Vector3& place) const;
  // Whether one of the two goes along their surfaces before the solve.
  bool GoesAlong(const ContactPoint& point, uint32_t id_a, uint32_t id_b) const;
  void AddPoint(const AddedPair& added, size_t number, const Grip& grip, bool direct);
  // Of the last point.
  void AddFrictions(const AddedPair& added, size_t number, const Grip& grip, bool direct);
  void AddFriction(const Vector3& direction, const Surface& surface);
  void AddTorsions();
  void AddRolling(uint32_t number);
  Torsion& AddTorsion(uint32_t normal, const Vector3& axis, double arm);

  uint32_t Iterations() const;
  void Sweep();
  // Returns the largest change of a rate.
  double SweepOnce(uint32_t sweep);
  double SweepFriction(const AddedPoint& point, const SolverRow& normal);
  double SweepTorsions();
  void PushApart();
  // One turn of a row in a sweep. Returns the change of its rate, and notes it.
  [[gnu::always_inline]] double Resolve(SolverRow& row, double wanted, double lower, double upper) {
    return Noted(row, Relax(row, wanted, lower, upper, row.impulse, changes_[row.a], changes_[row.b]));
  }
  double ResolveInDisc(SolverRow& first, SolverRow& second, double most) {
    return Noted(first, RelaxInDisc(first, second, most, changes_[first.a], changes_[first.b]));
  }
  double Noted(const SolverRow& row, double change) {
    stirred_.Note(row.a, row.b, change);
    return std::abs(change);
  }
  // Starts a row from `impulse`.
  void StartFrom(double impulse, SolverRow& row) {
    row.impulse = impulse;
    Apply(row, impulse, changes_[row.a], changes_[row.b]);
  }
  // Calls visit(row, lower, upper) with each row of a contact, and its bounds.
  template <typename Visit>
  void VisitRows(Visit visit);
  // After a sweep. False if no sweep will come nearer.
  bool Leap();
  // False: they cannot be found all at once.
  bool FindVelocities(BoundedSolver* bounded);
  // Pushes overlapping bodies apart, all at once; done as well if nothing is pushed faster than `settled` m/s. False as
  // above.
  bool PushDirectly(BoundedSolver* bounded, double settled);
  void TakeAll();
  bool IsStuck(uint32_t a, uint32_t b) const;
  void TakeImpulses();
  void TakeMotions();

  double step_size_ = 0;
  double pull_ = 0;  // m/s^2, of gravity
  uint32_t iterations_ = kPresetIterations;
  bool may_go_on_ = true;
  std::vector<SweptBody> bodies_;
  std::vector<AddedRow> rows_;
  std::vector<AddedPair> pairs_;
  Grips grips_;  // of pairs_
  // By number of the body.
  std::vector<MotionChange> changes_;   // of velocities
  std::vector<MotionChange> going_on_;  // velocities, were all points to push and brake as in the last step
  std::vector<MotionChange> moves_;     // velocities that only take overlaps apart
  std::vector<AddedPoint> points_;      // by row of their normal
  size_t point_count_ = 0;              // of pairs_
  bool are_few_ = false;                // see Begin(); of fewer iterations than a preset's none are
  std::vector<uint8_t> is_stuck_;       // by number of the body, of some: something is in the way of a joint of it
  bool goes_along_ = false;             // of few something GoesAlong()
  std::vector<SolverRow> normals_;
  std::vector<SolverRow> frictions_;
  std::vector<ContactPush> pushes_;  // of normals_, ascending
  Stirred stirred_;
  Leaps leaps_;
  DirectSolve direct_;
  Stirred pushed_;                  // the same of overlaps
  std::vector<BoundedRow> joints_;  // parallel to rows_
  std::vector<Torsion> torsions_;
  size_t turns_ = 0;  // of points and rows of joints, in the last sweep
};

}  // namespace genphys

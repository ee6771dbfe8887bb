#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "genphys/backend.h"
#include "genphys/islands.h"
#include "genphys/joint_index.h"
#include "genphys/layer_state.h"
#include "genphys/row_marks.h"
#include "genphys/row_set.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "genphys/stepper.h"
#include "joints/former_joints.h"
#include "joints/joint_body.h"
#include "joints/row_solver.h"
#include "joints/row_writer.h"
#include "joints/solve_energy.h"
#include "motion/mover.h"

namespace genphys {

/// rad in a substep: a body that joints turn farther has no momentum that says how it turns.
inline constexpr double kResolvedTurn = 0.7;

/// What joints hold where it is and as it moves, without inverses; or the world.
JointBody BodyNow(const Scene& scene, const StateArrays& state, EntityRow row);

/// The joints of a world over one step: what they add to the bodies they hold, rows for each solve, and what these come
/// to. Arguments outlive this object. It is kept from step to step for its memory only.
class JointStep {
 public:
  JointStep(const Scene& scene, const JointIndex& index, StateArrays& state, const RowSet& active, LayerState& layer)
      : scene_(scene), index_(index), state_(state), active_(active), layer_(layer) {}

  /// Begins a step without joints; Hold() adds them. `jointed`, which outlives the step, gets the rows that they hold.
  void Start(RowMarks& jointed);

  /// Adds the joints of an entity that moves, between substeps. Those of which nobody moves cost nothing.
  void Hold(EntityRow row);

  /// Whether any entity that these joints hold sleeps.
  bool HoldSleeper() const;

  /// Takes the velocities that are shown at the start of a substep, before it begins.
  void TakeShown();

  /// Begins a substep of `h` seconds, before forces act: poses and velocities are of its start, and tensors are set.
  void Begin(double h);

  /// Tells how a movable body is turned at the start of the substep that Begin() comes to.
  void SetTensors(EntityRow row, const TurnedTensors& turned);

  /// Tells of a body on joints what torques of the substep add to its spin (rad/s), by how much `turning` makes that
  /// another one on the mean, as the other way round in the last one, and its angular momentum with that.
  void Kick(EntityRow row, const Vector3& spin, const Vector3& turning, const Vector3& momentum, bool goes_on);

  /// The body as joints hold it in this substep, or null.
  const JointBody* Find(EntityRow row) const;
  /// Whether a joint on it was told otherwise, and goes on to the boundary as it did.
  bool IsDrivenOtherwise(EntityRow row) const { return former_.Concern(row); }

  /// The bodies that are harder to turn in this substep.
  std::span<const InertiaScale> scales() const { return scales_; }

  /// The rows of all joints that hold something awake, at the present poses, for a solve over `h` seconds. Others may
  /// be added behind them.
  std::vector<JointRow>& Write(double h);

  /// Solves all at once those of `rows` (as Write() gave them, with others behind) whose islands touch nothing, unless
  /// `solver` says otherwise: of the movable `moving` rows, with the contacts as they are. Returns those that are left
  /// to the engine, which TakeLeft() must follow. The solve is over `h` seconds. Until then the state has the
  /// velocities that move the bodies to where they shall be, and from then on those that they have.
  std::span<JointRow> Solve(Solver solver, double h, std::span<const EntityRow> moving, const ContactBuffer& contacts,
                            std::vector<JointRow>& rows);
  void TakeLeft(double h, std::vector<JointRow>& rows);

  /// Whether that solve followed the body through the substep, so that in the long run it gets no energy of it.
  bool IsFollowed(EntityRow row) const;
  /// Whether that solve was of this island, in which somebody is pushed otherwise from the boundary on: what it gave
  /// is the mean of what joints gave until there, and give since.
  bool GivesMean(EntityRow row) const;

  /// What a row shall be, m/s or rad/s, where it makes up for no error.
  static double QuietTarget(const JointRow& row);
  /// Solves an island (by its number) again without making up for errors, which gives no energy: its bodies and `rows`
  /// get what this comes to. False: that solve left it to the engine, or the numbers do not suffice.
  bool SolveQuietly(uint32_t island, std::vector<JointRow>& rows);
  /// Says which part of the way from there to the solve at least bodies must go, so that no more of an error is left to
  /// wait than who turns as these do makes in one substep.
  void BoundWaits(double h, std::span<const JointRow> rows, std::span<SolveEnergy> energies) const;

  /// Which bodies that solve held together.
  const Islands& islands() const { return islands_; }

  /// Whether what that solve `gained` the body (m/s) and `turned` it (rad/s) is no part of its course, because what was
  /// to be held together did not move together.
  bool IsJolted(EntityRow row, const Vector3& gained, const Vector3& turned) const;

  /// Allows each island (by its number) the energy that motors and springs gave it in that solve over `h` seconds, and
  /// what it takes to make up for errors; and says how much ways bend where somebody begins to turn.
  void AllowWork(double h, std::span<const JointRow> rows, std::span<SolveEnergy> energies) const;

  /// Takes what that solve made of the rows. Velocities must still be those by which it moved the bodies.
  void Take(double h);

  /// What joints hold together with an entity, as far as it can be moved, and the joints that hold that.
  struct Linked {
    std::vector<EntityRow> rows;  // the entity first
    std::vector<uint32_t> slots;  // ascending
    std::vector<uint32_t> loose;  // ascending; on one of the rows, and not what holds them together
  };
  /// Marks them in `seen`, which has none of them.
  Linked LinkedWith(EntityRow row, RowMarks& seen) const;
  /// The same of joints that lock something: others let go of each other in a blow.
  Linked TiedTo(EntityRow row, RowMarks& seen) const;

  /// Appends the rows of all that a joint locks, between these bodies where they are.
  void WriteLocked(uint32_t slot, const JointBody& a, const JointBody& b, std::vector<JointRow>& rows) const;

  /// Appends the rows of all locked axes of these, which are in `bodies` behind the world.
  void WriteLocks(const Linked& linked, std::span<const JointBody> bodies, std::vector<JointRow>& rows) const;

  /// What the last solve made of those rows of a joint that lock nothing, as they go on through the substep.
  std::vector<JointRow> LooseRows(uint32_t slot) const;

  /// How a body moves differently: m/s and rad/s.
  struct Change {
    EntityRow row{};
    Vector3 linear = Vector3::Zero();
    Vector3 angular = Vector3::Zero();
    bool is_pressed = false;  // something that it is held to is pressed against its limit from now on
  };
  /// Where a body is at the end of a substep in which what joints hold it to came to a limit, and how it goes on.
  struct Led {
    EntityRow row{};
    Pose pose;
    Vector3 linear_velocity = Vector3::Zero();  // m/s, of the centre of mass
    Vector3 momentum = Vector3::Zero();         // angular, kg*m^2/s, world
    Vector3 held_rate = Vector3::Zero();        // m/s^2, by joints from now on
    Vector3 held_torque = Vector3::Zero();      // N*m
  };
  /// By what acts from outside on an entity that has this velocity (m/s) and angular momentum (kg*m^2/s).
  using PushOf = absl::FunctionRef<genphys::Push(EntityRow, const Vector3& velocity, const Vector3& momentum)>;

  /// Marks all that joints hold together with what came to a limit in the last solve.
  void FindReached(RowMarks& reached);
  /// Of those limits, after a substep of `h` seconds: what touches nothing, and where one limit alone was reached, is
  /// `led` through it. Of all others what is left of the blows at its end: what was solved is what brings all of them
  /// to the right place, a part of the blow. With the rest, what a limit stopped moves as it was pulled away since, as
  /// far as what is locked lets it.
  std::vector<Change> LeaveReached(double h, PushOf push_of, std::vector<Led>& led);

  /// Tells that blows between two solves left a row of the joint to bear the impulse that it has.
  void Bear(uint32_t slot, const JointRow& row);

  /// Notes what the joints held over `step_size` seconds; returns those that must break, ascending.
  std::vector<JointId> Finish(double step_size);

  /// Undoes all of it.
  void Restore();

 private:
  class LimitCourse;

  struct Held {
    explicit Held(uint32_t joint) : slot(joint) {}

    uint32_t slot;
    uint32_t a = 0;  // in bodies_
    uint32_t b = 0;
    JointState before;  // the step
    ErrorCorrection correction;
    bool was_held = false;
    Vector3 force = Vector3::Zero();        // N*s on b so far
    Vector3 torque = Vector3::Zero();       // N*m*s on b so far
    Vector3 last_force = Vector3::Zero();   // N on b, in the last substep
    double share = 1;                       // of the substep, to the time for which its solve acts
    Vector3 force_begun = Vector3::Zero();  // N*s and N*m*s, as above, until this substep
    Vector3 torque_begun = Vector3::Zero();

    void BeginSubstep();
    // That part of the impulse of a row.
    void Bear(double part, const JointRow& row);
    // What its `rows` gave in this substep of `h` seconds was the mean of what they gave in the last step and give
    // since.
    void BearSince(double h, std::span<const JointRow> rows);
  };

  // How fast what is locked moved apart before the forces of the substep acted.
  struct Jolt {
    bool may_be = false;  // a body of the island begins anew
    double linear = 0;    // m/s
    double angular = 0;   // rad/s
  };

  // A motor that may come to what it is to reach in the substep.
  struct TurningMotor {
    uint32_t row;
    double most;        // N*s or N*m*s, with which it may push
    double sign;        // of its push until then
    double rate;        // m/s or rad/s, by now
    double pushed = 0;  // N*s or N*m*s, so far
    bool is_there = false;

    void Restore(JointRow& to) const;
    void Bound(JointRow& to, double left) const;
    void Drive(JointRow& to, double left) const;
  };

  std::span<JointBody> bodies() { return std::span(bodies_).first(body_count_); }
  std::span<const JointBody> bodies() const { return std::span(bodies_).first(body_count_); }
  void SortHeld();
  uint32_t BodyOf(const EntityRef& entity);
  ErrorCorrection CorrectionOf(const JointDesc& desc) const;
  bool MayHold(const JointDesc& desc) const;
  void Load(JointBody& body, double h) const;
  void Stiffen(double h);
  void CatchTorn(double h);
  template <typename Visit>
  void VisitPulls(std::span<const JointRow> rows, std::span<const uint32_t> mine, Visit&& visit);
  bool MayBeSurprised(std::span<const JointRow> rows, std::span<const uint32_t> mine, double h);
  bool IsSurprised(std::span<const JointRow> rows, std::span<const uint32_t> mine, double h);
  const JointBody& BodyAt(EntityRow side) const;
  // By how much more than its rate (m or rad per second) the row at `index` changes at most because what it is fixed to
  // turns, and of that because the line between two points does.
  double BendAt(std::span<const JointRow> rows, size_t index, double h) const;
  double BendOfLine(const JointRow& row, size_t index, double h) const;
  // Those of a joint that say where its point is.
  static bool BendsAlike(const JointRow& a, const JointRow& b);
  // Whether a row is aimed at more than the bend of its way.
  bool MakesUpForMuch(std::span<const JointRow> rows, std::span<const uint32_t> mine, double h) const;
  bool IsResolved(std::span<const uint32_t> mine, double h) const;
  // The constant spin (rad/s) that turns the body as its momentum after the solve does.
  Vector3 FlowOf(const JointBody& body, double h) const;
  double Aim(std::span<const uint32_t> mine, double h, std::vector<JointRow>& rows);
  bool SolveAgain(uint32_t island);
  bool Follow(uint32_t island, double h, std::vector<JointRow>& rows);
  bool SolveIsland(uint32_t island, double h, std::vector<JointRow>& rows);
  bool SolveAnew(uint32_t island, std::vector<JointRow>& rows);
  double InertiaOf(const JointRow& row) const;
  void FindTurning(std::span<const uint32_t> mine, std::span<const JointRow> rows);
  std::pair<TurningMotor*, double> FirstThere(std::span<const JointRow> rows);
  bool TurnMotors(uint32_t island, std::vector<JointRow>& rows);
  double RateBefore(const JointRow& row) const;
  double RateAfter(const JointRow& row) const;
  void FindJolts(std::span<const JointRow> rows);
  void WatchHaste(double h);
  void LeaveReached(const Linked& group, double h, std::vector<Change>& changes);
  // False: it is not so simple.
  bool FollowReached(const Linked& group, double h, PushOf push_of, std::vector<Led>& led);
  JointBody EndOf(EntityRow side, size_t place) const;
  // Those of a joint between bodies as they are, with nothing foretold, for a solve over `h` seconds.
  std::vector<JointRow> RowsBetween(uint32_t slot, const JointBody& a, const JointBody& b, double h) const;
  template <typename IsLoose>
  Linked LinkedWith(EntityRow row, RowMarks& seen, IsLoose&& is_loose) const;
  const JointRow* SolvedLimit(const Held& held, const JointRow& now) const;
  bool WriteReached(const Held& held, const JointBody& body_a, const JointBody& body_b, double h,
                    std::vector<JointRow>& rows) const;
  void Push(JointBody& body, double h);
  // How far the way of a joint over a substep of `h` seconds can be foretold, 0 to 1. Who turns far in it comes out
  // elsewhere.
  double TrustInTurns(const Held& held, double h) const;
  double TrustInPulls(const Held& held) const;
  // Appends the rows of one joint, aimed at where its bodies are expected to be as far (0 to 1) as that can be trusted.
  void WriteRowsOf(Held& held, double h, double trust, std::vector<JointRow>& rows);

  const Scene& scene_;
  const JointIndex& index_;
  StateArrays& state_;
  const RowSet& active_;
  LayerState& layer_;
  RowMarks* jointed_ = nullptr;
  std::vector<JointBody> bodies_{1};  // the first is the world
  size_t body_count_ = 1;             // of those, in this step
  std::vector<uint32_t> body_of_;     // by row; zero: no joint holds it
  std::vector<uint8_t> is_held_;      // by slot
  std::vector<Held> held_;            // in order of slots, once a substep begins
  FormerJoints former_;               // in the first substep
  std::vector<JointRow> rows_;
  std::vector<uint32_t> owners_;         // of rows_, in held_
  std::vector<double> expected_, told_;  // scratch
  std::vector<InertiaScale> scales_;
  Islands islands_;
  RowSolver solver_;
  std::vector<uint8_t> is_solved_;    // by island: not left to the engine
  std::vector<uint8_t> gives_mean_;   // by island: see GivesMean()
  std::vector<double> targets_;       // scratch
  std::vector<JointRow> aimed_;       // scratch
  std::vector<Jolt> jolts_;           // by island; none without rows
  std::vector<TurningMotor> motors_;  // of the island that is solved
  std::vector<Linked> reached_;       // limits, in the last solve
  std::vector<JointRow> left_rows_;
  std::vector<uint32_t> left_;  // in rows
};

}  // namespace genphys

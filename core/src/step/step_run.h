#pragma once
#include <chrono>
#include <optional>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "genphys/world.h"
#include "impacts/impact_sweep.h"
#include "impacts/impacts.h"
#include "joints/joint_step.h"
#include "motion/field_forces.h"
#include "motion/locked_axes.h"
#include "motion/mover.h"
#include "pairs/disjoint_sets.h"
#include "pairs/ordered_search.h"
#include "step/courses.h"
#include "step/step_scratch.h"
#include "step/step_undo.h"
#include "step/touching.h"

namespace genphys {

/// One step of one world, from the boundary before it to the boundary after it.
class StepRun {
 public:
  StepRun(World& world, double step_size);

  /// All but OK leaves all as it was; after DIVERGED the engine is gone.
  Status Run();

 private:
  struct BendSide;
  class Crowd;
  class Foretold;
  class Jolts;
  class Misdrawn;
  class Rolls;
  struct Rubbed;
  class Spread;
  class Stops;
  class Turns;

  // A dynamic body that nothing can meet in this step.
  struct Flyer {
    EntityRow row{};
    Vector3 acceleration = Vector3::Zero();
  };

  void Advance();
  void RunEngine(uint32_t substeps);
  void SettleBeforehand();
  void ForgetUnsettled();
  void CollectRows();
  // Tells the layer where the entity's geometries are.
  void Place(EntityRow row);
  // Finds what touches, of the pairs of `moved` alone unless it is null, and wakes whom that wakes, with what those
  // touch. Whom it wakes is marked as changed.
  void CollideAndWake(const std::vector<EntityRow>* moved);
  void FinishJoints();
  void Substep(double h, double elapsed);
  void Solve(double h);
  // Brings bodies (ascending) back to how they were before the solve.
  void ReturnToStart(std::span<const EntityRow> rows);
  void RestrainJoints(double h, std::vector<JointRow>& rows);
  void MoveKinematic(double h);
  void Undo();
  void UndoLongWork();
  ContactBudget BudgetWithin() const;
  void StartMover(EntityRow row, Mover& mover);
  bool IsDynamic(EntityRow row) const;
  bool IsMoved(EntityRow row) const { return world_.active_[Index(row)] && IsDynamic(row); }
  double MassOf(EntityRow row) const { return world_.scene_.entities[Index(row)]->mass.mass; }  // kg
  bool Fits(EntityRow row) const;
  void Retire(std::span<const EntityRow> strays);
  // Of those whose marks are set, if there are marks.
  void RetireStrays(const RowMarks* changed = nullptr);
  void Mark(std::string_view stage);

  // Who is woken (step_wake.cc).
  bool WakeTouched();
  void WakeCarried(std::vector<EntityRow>& carried) const;
  // CollideAndWake() of who was woken last.
  void CollideWoken();
  void WakeMet(double h);
  std::vector<EntityRow> FindMet(double h);
  void FindDrives(double h);
  double DriveOf(const ContactPair& pair, double h) const;
  double DriveOf(const JointDesc& joint, double h) const;
  Push WholePush(EntityRow row) const;
  Push NewPush(EntityRow row) const;
  Vector3 GainAt(EntityRow row, const Push& push, const Vector3& point, double h) const;

  // The ways of kinematic bodies (step_passages.cc).
  // Returns those whose way is over, who may be elsewhere now.
  std::vector<EntityId> StartPassages();
  bool Lead(EntityId id, Passage& passage);
  void FillLedSlips(double h);

  // The flight lane (step_flight.cc).
  bool MayFly(EntityRow row) const;
  void MarkListed(std::span<const EntityId> listed);
  void MarkSteered();
  bool MayMeetField(EntityRow row, const Vector3& acceleration) const;
  Bounds RegionOf(EntityRow row, const Vector3& acceleration, const Vector3& drift) const;
  Vector3 CommonVelocity() const;
  Vector3 CommonWay() const;
  void ReserveFlyers(const Vector3& drift);
  bool Drift();
  void ChooseFlyers();
  void GroundThoseThatMeet();
  static double ThicknessOf(const SceneEntity& entity);
  void GroundMet(double elapsed);
  bool GroundPassed(const Swept& swept, double h, double elapsed, std::vector<FlownWay>& flown,
                    std::vector<FlownWay>& ways);
  void Ground(EntityRow row, double elapsed);
  void ForgetGrounded();
  void Fly(const Flyer& flyer, double time);
  void FinishFlight();

  // Forces (step_kick.cc).
  Wrench WrenchOf(const PendingForce& pending) const;
  void GatherForces();
  void GatherSamples();
  Push AddSample(Mover& mover) const;
  void GatherFields(double h);
  Push SteadyPush(EntityRow row) const;
  Push FieldPush(EntityRow row) const;
  Pose LedFrom(EntityRow row, double time) const;
  bool WakeSwept(std::span<const SweptPair> swept);
  bool IsUntouched(const Mover& mover, Vector3 gained, Vector3 turned) const;
  void NoteTurn(EntityRow row, const Vector3& acceleration);
  void TakeSteady(Mover& mover);
  void BeginMovers();
  void BeginMover(Mover& mover);
  void KickMover(Mover& mover, double h);
  void TakeTensors(Mover& mover) const;
  std::optional<Resistance> ResistanceOf(const Mover& mover) const;
  static Motion Slowed(const std::optional<Resistance>& resistance, double time, const Motion& before,
                       const Motion& pushed, const Motion& given);
  static Vector3 TorqueOn(const std::optional<Resistance>& resistance, const Vector3& momentum, const Vector3& twist,
                          double h);
  void HoldOver(const Mover& mover, double h, const Vector3& gained, const Vector3& turned);
  void EndMover(Mover& mover, double h);
  void KeepEarned(Mover& mover, double h, const Vector3& turned);

  // Who is let go of (step_release.cc).
  bool Holds(const ContactPair& pair) const;
  // Of `among` alone, unless it is null.
  void PayReleased(const RowMarks* among);
  void PayAcross(const RowMarks& paid);
  void PayPart(const ContactPair& pair, EntityRow row);
  void VisitHeldTogether(absl::FunctionRef<bool(const ContactPair&)> holds,
                         absl::FunctionRef<void(uint32_t, uint32_t)> join);
  DisjointSets HangTogether();
  void RestartFallen();
  void RestartCarried();
  void RestartTogether();

  // What is owed after blows within contacts (step_jolts.cc).
  void ShareJolts(double h);

  // What pushes out of overlaps would give to turning (step_spread.cc).
  void SlowSpread(double h);

  // Contacts (step_contacts.cc).
  Vector3 CenterOf(EntityRow row) const;
  Vector3 VelocityAt(EntityRow row, const Vector3& center, const Vector3& point) const;
  // At the points of the pairs of `changed` alone unless it is null.
  void FillRelativeVelocities(const RowMarks* changed);
  void PrepareContacts(double h);
  void RoughenSliding(ContactPair& pair, double h);
  // What the last solve left of the pair, or null.
  const ContactPair* SolvedBefore(const ContactPair& pair) const;
  double IntervalOf(const ContactPair& pair, double h) const;
  void ShareImpulses(double h);
  void NoteUneven(const ContactPair& pair, double h);
  void NoteLever(const ContactPair& pair, double h);
  // What met in the substep just done, or what a command made meet before the first one: at first in pairs of `among`
  // alone, unless it is null.
  void ResolveImpacts(double h, double elapsed, bool after_move, const RowMarks* among);
  ImpactWorld Surroundings();
  std::vector<FlownWay> FlownWays(double h) const;
  static std::vector<FlownWay> NewWays(const Impacts& impacts, std::vector<FlownWay>& flown);
  void AddCrossing(std::span<const FlownWay> flown, std::vector<FlownWay>& ways) const;
  void AddVisits();
  Swept SweepAlong(double h, double elapsed, std::vector<FlownWay>& flown, std::vector<FlownWay>& ways,
                   const RowMarks*& looked_at);
  void TellMoved(const std::vector<EntityRow>& rows, double elapsed, const RowMarks*& looked_at);

  // Who has no turn any more in the impacts of a substep (step_stops.cc).
  void StopThoseLeft(double h, double elapsed, std::vector<FlownWay>& flown, std::vector<FlownWay>& ways,
                     const RowMarks*& looked_at);

  // In which direction joints and other contacts draw what they hold (step_draws.cc).
  void CountPartners();
  bool IsDrawn(const ContactPair& pair) const;
  Vector3 DrawnBy(const ContactPair& pair, const Rubbed& friction, absl::FunctionRef<Push(EntityRow)> gain_of) const;
  Vector3 DrawnBefore(const ContactPair& pair, double h) const;
  void SolveMisdrawn(double h, std::span<JointRow> left);

  // How surfaces slip for their bodies turn (step_bends.cc).
  struct Bend {
    Vector3 slip = Vector3::Zero();  // m/s
    double parting = 0;              // m/s
  };
  BendSide BendSideOf(EntityRow entity, GeometryRow row, double sign) const;
  Bend RolledBend(const ContactPair& pair, const ContactPoint& point, double h) const;
  Vector3 FlatBend(const ContactPair& pair, const Vector3& place, double h) const;
  void FindBends(double h);

  // Friction that turns within a substep (step_turns.cc).
  void FindTurns(double h);
  void GiveTurns();
  void KickTurned(const FrictionTurn& turn, EntityRow row);
  void TakeTurns(double h);
  void NoteTurned();
  void KeepTurns();
  void ShiftTurned();

  // Resistance to rolling that does (step_rolls.cc).
  void FindRolls(double h);
  void GiveRolls();
  void KickRolled(const RollTurn& turn);
  void TakeRolls();
  void KeepRolls();

  // What joints stop at their limits (step_limits.cc).
  void LeaveLimits(double h);
  Push BrakedPush(EntityRow row, double h, const Vector3& velocity, const Vector3& momentum) const;
  void Lead(const JointStep::Led& led, double h);

  // What is told of the step (step_report.cc).
  void FinishNetForces();
  void CountForcesDown();
  void Report();
  void PutToSleep(EntityRow row);
  void CountIslands();
  void FillStats(size_t fell_asleep);

  // Of what a contact gives in a substep, what it gives in the half of it that the velocities of its middle lack.
  static constexpr double kOwed = 0.5;
  // m: a contact with a wider gap touches nothing yet.
  static constexpr double kReleaseGap = 1e-3;

  World& world_;
  double step_size_;
  double substep_ = 0;  // s
  Solver solver_ = Solver::kAutomatic;
  bool ran_ = false;                // something was moved
  bool is_first_ = true;            // substep
  bool is_anybody_jolted_ = false;  // in this substep
  bool are_contacts_new_ = false;   // not those that the last step left
  StateArrays& state_;
  StepScratch& scratch_;
  FieldForces fields_;
  StepUndo undo_;
  std::vector<Mover>& movers_;
  std::vector<EntityRow> rows_;  // of movers_, ascending; at the start of a step with those of flyers_
  std::vector<Flyer> flyers_;
  FieldForces::Reach field_reach_;
  std::vector<EntityRow> kinematic_rows_;  // active ones, ascending
  Courses courses_;                        // of these
  StepTouches touches_;
  JointStep& joints_;
  LockedBodies locked_;
  mutable OrderedSearch solved_search_;
  std::vector<SweptPair> visits_;      // of sensors in this substep, by who was not stopped before
  std::vector<EntityRow> unfinished_;  // of whom impacts were left at the end of the last substep
  std::vector<JointBroke> broken_;
  std::vector<EntityId> faulted_;
  std::chrono::steady_clock::time_point mark_;
};

}  // namespace genphys

#include <algorithm>
#include <cmath>
#include <ranges>
#include <utility>

#include "genphys/limits.h"
#include "genphys/work_watch.h"
#include "model/cat.h"
#include "model/validate.h"
#include "motion/free_rotation.h"
#include "pairs/near_pairs.h"
#include "step/event_order.h"
#include "step/restraint.h"
#include "step/sleeping.h"
#include "step/step_run.h"
#include "world/initial_world.h"

namespace genphys {
Status World::Step(std::optional<double> step_size) {
  if (faulted_) return Refuse(Reason::kWorldFaulted, "", "the world is faulted: it can be read and reset");
  const double size = step_size.value_or(scene_.world.stepper.step_size);
  GENPHYS_RETURN_IF_ERROR(CheckNumber(size, Limits::kStepSizeMin, Limits::kStepSizeMax, "step_size_seconds"));
  if (scratch_ == nullptr) scratch_ = std::make_unique<StepScratch>();
  MarkBeginning();
  const Status status = StepRun(*this, size).Run();
  // The first step is still to come, and what commands do until then is there before it.
  if (!status.ok() && !faulted_) ForgetBeginning();
  return status;
}

void World::MarkBeginning() {
  if (layer_.step == 0 && initial_ == nullptr) initial_.reset(new Initial{scene_, state_, layer_});
}

void World::ForgetBeginning() {
  if (layer_.step == 0) initial_.reset();
}

bool World::IsAtRest() const {
  if (faulted_) return false;
  return engine_ == nullptr || (active_count_ == 0 && layer_.passages.empty() && woken_.empty());
}

void World::StepAtRest(uint64_t count) {
  // One by one, for the time to be that of as many steps to the last bit.
  for (uint64_t i = 0; i < count; ++i) layer_.simulation_time += scene_.world.stepper.step_size;
  if (count == 0) return;
  layer_.step += count;
  layer_.former_drives.clear();
  layer_.former_frames.clear();
  lately_active_.Clear();
}

StepRun::StepRun(World& world, double step_size)
    : world_(world),
      step_size_(step_size),
      state_(world.state_),
      scratch_(*world.scratch_),
      fields_(world.scene_, world.state_),
      undo_(world),
      movers_(scratch_.movers),
      courses_(world.layer_, world.state_, step_size),
      touches_(world.rule_, world.state_, world.scene_.world.recorded_events, world.layer_.touching),
      joints_(*world.joint_step_),
      locked_(world.scene_, world.state_) {}

Status StepRun::Run() {
  if (world_.record_stats_) {
    world_.stats_ = {};
    mark_ = std::chrono::steady_clock::now();
  }
  if (world_.engine_ != nullptr) {
    const std::vector<EntityId> arrived = StartPassages();
    CollectRows();
    // They stand still from here on, and are not among those who are active.
    for (const EntityId id : arrived) world_.lately_active_.Add(id.index());
    // Nothing moves, so nothing can come to touch: nothing is called.
    if (!rows_.empty() || !kinematic_rows_.empty()) {
      ++world_.changes_;
      try {
        const WorkBudget budget(world_.budget_.looks);
        Advance();
      } catch (const BudgetExceeded& why) {
        Undo();
        return world_.OverBudget(why.what(), undo_.is_engine_spoilt());
      } catch (const TooMuchWork& why) {
        UndoLongWork();
        return world_.OverBudget(why.what(), undo_.is_engine_spoilt());
      } catch (const CutShort& cut) {
        UndoLongWork();
        return world_.Undone(cut.why(), undo_.is_engine_spoilt());
      } catch (const EngineFault& fault) {
        // It is beyond use after a fault.
        world_.engine_.reset();
        Undo();
        return world_.Diverged(fault.what());
      }
    }
  }
  world_.layer_.former_drives.clear();
  world_.layer_.former_frames.clear();
  ++world_.layer_.step;
  world_.layer_.simulation_time += step_size_;
  if (world_.engine_ != nullptr) Report();
  return absl::OkStatus();
}

void StepRun::Mark(std::string_view stage) {
  if (!world_.record_stats_) return;
  const auto now = std::chrono::steady_clock::now();
  const auto spent = static_cast<uint64_t>(std::chrono::nanoseconds(now - mark_).count());
  mark_ = now;
  auto& stages = world_.stats_.stages;
  const auto same = std::find_if(stages.begin(), stages.end(), [&](const auto& s) { return s.name == stage; });
  if (same == stages.end()) {
    stages.push_back({stage, spent});
  } else {
    same->nanoseconds += spent;
  }
}

bool StepRun::IsDynamic(EntityRow row) const { return world_.scene_.entities[Index(row)]->traits.is_dynamic; }

void StepRun::CollectRows() {
  if (world_.active_count_ == 0) return world_.lately_active_.Clear();
  world_.lately_active_ = world_.active_;
  world_.active_.ForEach([&](uint32_t index) {
    const EntityRow row{index};
    (IsDynamic(row) ? rows_ : kinematic_rows_).push_back(row);
  });
}

// What took too long is not done once more for the sake of how it was before.
void StepRun::UndoLongWork() {
  const WorkWatch whole({});
  undo_.LeaveContactsToBeFound();
  Undo();
}

void StepRun::Undo() {
  joints_.Restore();
  undo_.Undo();
}

// `mover` may be of an earlier step: mostly the same move as in the last one, and are turned as that left them.
void StepRun::StartMover(EntityRow row, Mover& mover) {
  const Matrix3& tensor = world_.scene_.entities[Index(row)]->mass.tensor;
  if (mover.row != row || mover.turned.own != tensor) {
    mover.turned = {.own = tensor};
  }
  mover.row = row;
  mover.start = state_.pose(row);
  scratch_.accelerations[row] = SteadyPush(row).acceleration;
  mover.linear_start = state_.linear_velocities.col(Index(row));
  TakeTensors(mover);
  mover.momentum_start = mover.turned.tensor * state_.angular_velocities.col(Index(row));
}

// Within a step there may be somewhat more than a step may begin with. So what grows slowly is refused between two
// steps, where there is nothing to be undone that the engine keeps to itself.
ContactBudget StepRun::BudgetWithin() const {
  return {world_.budget_.pairs + world_.budget_.pairs / 4, world_.budget_.points + world_.budget_.points / 4};
}

void StepRun::Advance() {
  world_.near_->set_budget(BudgetWithin());
  world_.roused_.clear();
  world_.StirLying();
  scratch_.Begin(state_.rows());
  ran_ = true;
  GatherForces();
  GatherSamples();
  joints_.Start(scratch_.jointed);
  for (const EntityRow row : rows_) joints_.Hold(row);
  for (const EntityRow row : kinematic_rows_) joints_.Hold(row);
  ChooseFlyers();
  undo_.Reserve(rows_.size() + kinematic_rows_.size());
  for (EntityRow row : rows_) undo_.Keep(row);
  for (EntityRow row : kinematic_rows_) undo_.Keep(row);
  movers_.resize(rows_.size());
  for (size_t i = 0; i < rows_.size(); ++i) StartMover(rows_[i], movers_[i]);
  Mark("choose");
  const StepperSettings settings = world_.backend_->Resolve(world_.scene_.world.stepper);
  const uint32_t substeps = settings.substeps;
  substep_ = step_size_ / substeps;
  solver_ = settings.solver;
  if (world_.contacts_stale_) {
    are_contacts_new_ = true;
    CollideAndWake(nullptr);
  } else if (WakeTouched()) {
    CollideWoken();
  }
  world_.near_->Check(world_.budget_, world_.contacts_);
  if (rows_.empty() && kinematic_rows_.empty()) {
    world_.solved_.Clear();
    ForgetUnsettled();
  } else {
    RunEngine(substeps);
  }
  FinishFlight();
  CountForcesDown();
  world_.layer_.last_step = step_size_;
}

// What contacts, joints or command move, in the engine's lane.
void StepRun::RunEngine(uint32_t substeps) {
  // Commands may have made somebody too fast, whom nobody is to meet then.
  RetireStrays();
  courses_.Find(kinematic_rows_);
  SettleBeforehand();
  for (uint32_t i = 0; i < substeps; ++i) {
    courses_.Follow((i + 0.5) / substeps, *world_.engine_);
    Substep(substep_, i * substep_);
  }
  courses_.End(*world_.engine_);
  FinishNetForces();
  ForgetUnsettled();
  // Too many met for one substep.
  for (const EntityRow row : unfinished_) world_.Unsettle(row);
  for (const EntityRow row : courses_.Uneven()) world_.Unsettle(row);
  FinishJoints();
}

// What commands did since the last step: who is let go of, falls with others, is carried otherwise or meets somebody.
// Others are not looked at, so that they go on as if no command had come.
void StepRun::SettleBeforehand() {
  // What is an impact is told by the length of a substep.
  const bool is_all = world_.is_all_unsettled_ || substep_ != world_.layer_.last_substep;
  if (!is_all && world_.unsettled_.empty()) {
    if (!are_contacts_new_) return;
    world_.near_->PutInOrder(world_.contacts_);
    return FillRelativeVelocities(nullptr);
  }
  const RowMarks* const unsettled = is_all ? nullptr : &world_.unsettled_;
  PayReleased(unsettled);
  RestartFallen();
  RestartCarried();
  ResolveImpacts(substep_, 0, false, unsettled);
}

void StepRun::ForgetUnsettled() {
  world_.unsettled_.Clear();
  world_.let_go_.Clear();
  world_.is_all_unsettled_ = false;
}

void StepRun::FinishJoints() {
  for (JointId id : joints_.Finish(step_size_)) broken_.push_back(world_.Break(id));
  world_.SettleAftermath();
}

void StepRun::Place(EntityRow row) {
  const RigidBody& body = *world_.scene_.entities[Index(row)]->desc->rigid_body;
  world_.near_->Place({body, world_.geometry_rows_[Index(row)]}, state_.pose(row));
}

void StepRun::CollideAndWake(const std::vector<EntityRow>* moved) {
  const auto mark_moved = [&](const std::vector<EntityRow>& rows) {
    scratch_.moved.Clear();
    for (const EntityRow row : rows) scratch_.moved.Mark(row);
  };
  if (moved != nullptr) mark_moved(*moved);
  undo_.LoseContacts();
  bool is_all_new = moved == nullptr, is_anybody_woken = false;
  do {
    for (const std::vector<EntityRow>* rows : {&rows_, &kinematic_rows_, &world_.roused_}) {
      for (const EntityRow row : *rows) scratch_.tested.Mark(row);
    }
    if (is_all_new && !is_anybody_woken) {
      world_.near_->Collide(world_.rule_, *world_.engine_, world_.contacts_);
    } else {
      world_.near_->CollideMoved(world_.rule_, *world_.engine_, scratch_.moved, world_.contacts_);
    }
    world_.contacts_stale_ = false;
    is_anybody_woken = WakeTouched();
    // Who was woken may touch others, of whom nothing is known yet.
    if (is_anybody_woken) mark_moved(world_.roused_);
    is_all_new = is_all_new || is_anybody_woken;
  } while (is_anybody_woken);
  world_.StirLying();
  // Whoever was woken moves from here on.
  for (const EntityRow row : std::exchange(world_.roused_, {})) {
    scratch_.changed.Mark(row);
    if (!world_.active_[Index(row)] || !IsDynamic(row)) continue;
    const auto place = std::lower_bound(rows_.begin(), rows_.end(), row);
    if (place != rows_.end() && *place == row) continue;
    rows_.insert(place, row);
    StartMover(row, movers_.emplace_back());
    joints_.Hold(row);
    locked_.Hold(row);
  }
  Mark("collide");
}

void StepRun::Substep(double h, double elapsed) {
  is_first_ = elapsed == 0;
  WakeMet(h);
  FindBends(h);
  FillLedSlips(h);
  joints_.TakeShown();
  BeginMovers();
  joints_.Begin(h);
  GatherFields(h);
  FindTurns(h);
  FindRolls(h);
  for (Mover& mover : movers_) KickMover(mover, h);
  RetireStrays();
  locked_.Begin(rows_);
  PrepareContacts(h);
  GiveTurns();
  GiveRolls();
  Mark("kick");
  Solve(h);
  Mark("solve");
  joints_.Take(h);
  scratch_.reached.Clear();
  joints_.FindReached(scratch_.reached);
  scratch_.uneven.Clear();
  TakeTurns(h);
  TakeRolls();
  ShareImpulses(h);
  world_.engine_->WriteState(locked_.Finish(), state_);
  GatherForces();
  GatherFields(h);
  is_anybody_jolted_ = false;
  for (Mover& mover : movers_) EndMover(mover, h);
  ShareJolts(h);
  SlowSpread(h);
  ShiftTurned();
  LeaveLimits(h);
  locked_.DropVelocities();
  MoveKinematic(h);
  world_.layer_.last_substep = h;
  RetireStrays();
  touches_.AddSolved(world_.contacts_);
  NoteTurned();
  KeepTurns();
  KeepRolls();
  undo_.KeepSolved();  // nothing between the solve and this can be over the budget
  std::swap(world_.contacts_, world_.solved_);
  for (EntityRow row : rows_) Place(row);
  for (EntityRow row : kinematic_rows_) Place(row);
  Mark("layer");
  GroundMet(elapsed + h);
  CollideAndWake(nullptr);
  PayReleased(nullptr);
  ResolveImpacts(h, elapsed + h, true, nullptr);
}

void StepRun::Solve(double h) {
  std::vector<JointRow>& rows = locked_.Write(world_.contacts_, joints_.Write(h));
  const std::span<JointRow> left = joints_.Solve(solver_, h, rows_, world_.contacts_, rows);
  world_.engine_->ScaleInertia(joints_.scales());
  undo_.SpoilEngine();
  world_.engine_->Solve(h, rows_, state_, world_.contacts_, left);
  SolveMisdrawn(h, left);
  joints_.TakeLeft(h, rows);
  RestrainJoints(h, rows);
}

// Velocities as they were given, with what friction gave that turns within the substep.
void StepRun::ReturnToStart(std::span<const EntityRow> rows) {
  const auto is_one = [&](EntityRow row) { return std::ranges::binary_search(rows, row); };
  for (const Mover& mover : movers_) {
    if (!is_one(mover.row)) continue;
    state_.set_pose(mover.row, mover.start);
    state_.linear_velocities.col(Index(mover.row)) = mover.linear_given;
    state_.angular_velocities.col(Index(mover.row)) = mover.spin_given;
  }
  for (const FrictionTurn& turn : scratch_.turns) {
    if (turn.rest == 1) continue;
    for (const EntityRow row : {turn.a, turn.b}) {
      if (is_one(row)) KickTurned(turn, row);
    }
  }
  for (const RollTurn& turn : scratch_.rolls) {
    if (turn.rest < 1 && is_one(turn.row)) KickRolled(turn);
  }
  world_.engine_->WriteState(rows, state_);
}

void StepRun::RestrainJoints(double h, std::vector<JointRow>& rows) {
  const auto return_to_start = [this](std::span<const EntityRow> left) { ReturnToStart(left); };
  const Restraint::Surroundings surroundings{.scene = world_.scene_,
                                             .layer = world_.layer_,
                                             .rule = world_.rule_,
                                             .active = world_.active_,
                                             .state = state_,
                                             .contacts = world_.contacts_,
                                             .engine = *world_.engine_,
                                             .joints = joints_,
                                             .movers = movers_,
                                             .return_to_start = return_to_start};
  Restraint(surroundings, h).Apply(rows);
}

void StepRun::MoveKinematic(double h) {
  for (EntityRow row : kinematic_rows_) {
    const Pose pose = state_.pose(row);
    state_.set_pose(row, {pose.position + h * state_.linear_velocities.col(Index(row)),
                          Turned(pose.orientation, state_.angular_velocities.col(Index(row)), h)});
  }
  // Bodies of unequal moments and bounced ones have another velocity than the engine knows; it is told at the next
  // solve, so only the poses that the layer moved are written.
  world_.engine_->WriteState(kinematic_rows_, state_);
}

bool StepRun::Fits(EntityRow entity) const {
  const uint32_t row = Index(entity);
  // Comparisons that are false for NaN as well; a unit quaternion has no element beyond one.
  const auto within = [](const auto& column, double bound) {
    if (column.squaredNorm() <= bound * bound) return true;
    bool is_within = true;
    for (const double element : column) is_within &= std::abs(element) <= bound;
    return is_within;
  };
  return within(state_.positions.col(row), Limits::kPositionMax) && within(state_.orientations.col(row), 1.5) &&
         within(state_.linear_velocities.col(row), Limits::kSpeedMax) &&
         within(state_.angular_velocities.col(row), Limits::kSpinMax);
}

void StepRun::RetireStrays(const RowMarks* changed) {
  std::vector<EntityRow> strays;
  for (const std::vector<EntityRow>* rows : {&rows_, &kinematic_rows_}) {
    for (EntityRow entity : *rows) {
      if ((changed != nullptr && !(*changed)[entity]) || Fits(entity)) continue;
      const uint32_t row = Index(entity);
      const bool finite = state_.positions.col(row).allFinite() && state_.orientations.col(row).allFinite() &&
                          state_.linear_velocities.col(row).allFinite() &&
                          state_.angular_velocities.col(row).allFinite();
      if (!finite) throw EngineFault(Cat("entity ", state_.ids[row].packed(), " is no longer finite"));
      strays.push_back(entity);
    }
  }
  if (!strays.empty()) Retire(strays);
}

void StepRun::Retire(std::span<const EntityRow> strays) {
  for (const EntityRow row : strays) scratch_.strays.Mark(row);
  const auto is_stray = [&](EntityRow row) { return scratch_.strays[row]; };
  undo_.KeepPassages();
  undo_.KeepForces();
  // The earliest of one row is put last.
  for (const StepUndo::Row& saved : undo_.rows() | std::views::reverse) {
    if (is_stray(saved.row)) state_.set_pose(saved.row, saved.pose);
  }
  for (const EntityRow entity : strays) {
    const uint32_t row = Index(entity);
    state_.linear_velocities.col(row).setZero();
    state_.angular_velocities.col(row).setZero();
    state_.asleep[row] = true;
    world_.layer_.faulted[row] = true;
    world_.layer_.half_steps[row].Forget();
    world_.TellPose(entity);
    world_.UpdateActive(entity);
    locked_.Forget(entity);
    world_.EndPassage(state_.ids[row]);
    faulted_.push_back(state_.ids[row]);
  }
  std::erase_if(rows_, is_stray);
  std::erase_if(kinematic_rows_, is_stray);
  std::erase_if(movers_, [&](const Mover& mover) { return is_stray(mover.row); });
  std::erase_if(world_.layer_.forces, [&](const PendingForce& force) { return is_stray(EntityRow{force.id.index()}); });
}

}  // namespace genphys

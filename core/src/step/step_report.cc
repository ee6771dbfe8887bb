// What a step tells when it is over: net forces, events, who falls asleep, statistics.
#include <algorithm>
#include <utility>

#include "motion/free_rotation.h"
#include "step/event_order.h"
#include "step/resting.h"
#include "step/sleeping.h"
#include "step/step_run.h"

namespace genphys {

void StepRun::FinishNetForces() {
  for (Mover& mover : movers_) {
    const uint32_t row = Index(mover.row);
    const MassProperties& mass = world_.scene_.entities[row]->mass;
    TakeTensors(mover);
    const Vector3 momentum = mover.turned.tensor * state_.angular_velocities.col(row);
    state_.net_forces.col(row) = mass.mass / step_size_ * (state_.linear_velocities.col(row) - mover.linear_start);
    state_.net_torques.col(row) = (momentum - mover.momentum_start) / step_size_;
  }
}

void StepRun::CountForcesDown() {
  std::vector<SampledForce>& samples = world_.layer_.samples;
  samples.clear();
  for (const PendingForce& force : world_.layer_.forces) {
    const EntityRow row{force.id.index()};
    if (!force.is_sampled || !scratch_.is_sampled[row]) continue;
    scratch_.is_sampled.Unmark(row);
    const Wrench& sum = scratch_.samples[row];
    samples.push_back({force.id, sum.force, sum.torque});
  }
  std::ranges::sort(samples, {}, &SampledForce::id);
  world_.layer_.samples_step = samples.empty() ? 0 : step_size_;
  for (PendingForce& force : world_.layer_.forces) --force.steps_left;
  std::erase_if(world_.layer_.forces, [](const PendingForce& force) { return force.steps_left == 0; });
}

void StepRun::Report() {
  LayerState& layer = world_.layer_;
  std::vector<EventKind> events;
  if (ran_) {
    touches_.AddFinal(world_.contacts_);
    touches_.KeepUntested(scratch_.tested);
    touches_.Report(events);
    layer.touching = touches_.Pairs();
  }
  const EventKinds& kinds = world_.scene_.world.recorded_events;
  for (EntityId id : world_.woken_) events.push_back(EntityWoke{id});
  world_.woken_.clear();
  CountIslands();
  const auto in_engine = static_cast<std::ptrdiff_t>(rows_.size());
  for (const Flyer& flyer : flyers_) rows_.push_back(flyer.row);
  std::inplace_merge(rows_.begin(), rows_.begin() + in_engine, rows_.end());
  const auto swings = [this](EntityRow row) {
    scratch_.linked.Clear();
    return std::ranges::none_of(joints_.TiedTo(row, scratch_.linked).rows,
                                [this](EntityRow tied) { return scratch_.held[tied]; });
  };
  const RestMarks marks{.pushed = scratch_.pushed, .jointed = scratch_.jointed, .swings = swings};
  AdvanceRests(world_.scene_, state_, rows_, marks, step_size_, layer);
  const std::vector<EntityRow> sleepers =
      RowsToSleep(world_.scene_, rows_, world_.joint_index_, world_.active_, layer, scratch_.places);
  world_.RememberTouches(sleepers);
  for (EntityRow row : sleepers) {
    PutToSleep(row);
    if (kinds.sleeping) events.push_back(EntitySlept{state_.ids[Index(row)]});
  }
  if (!sleepers.empty()) {
    world_.LayLying();
    world_.engine_->PutAway();
    world_.near_->PutAway();
  }
  if (kinds.moving) ReportMoving(world_.scene_, state_, rows_, layer, events);
  for (EntityId id : faulted_) {
    state_.net_forces.col(id.index()).setZero();
    state_.net_torques.col(id.index()).setZero();
    if (kinds.changes) events.push_back(EntityFaulted{id});
  }
  if (kinds.joints) {
    for (const JointBroke& broken : broken_) events.push_back(broken);
  }
  SortCanonically(events);
  for (EventKind& event : events) world_.Record(std::move(event));
  Mark("report");
  FillStats(sleepers.size());
}

void StepRun::PutToSleep(EntityRow entity) {
  const uint32_t row = Index(entity);
  state_.asleep[row] = true;
  const Matrix3 tensor = WorldTensor(state_.pose(entity).orientation, world_.scene_.entities[row]->mass.tensor);
  world_.layer_.half_steps[row].Rest(state_.linear_velocities.col(row), tensor * state_.angular_velocities.col(row));
  state_.linear_velocities.col(row).setZero();
  state_.angular_velocities.col(row).setZero();
  state_.net_forces.col(row).setZero();
  state_.net_torques.col(row).setZero();
  world_.TellPose(entity);
  world_.UpdateActive(entity);
}

// While rows_ are still those of the engine's lane.
void StepRun::CountIslands() {
  if (!world_.record_stats_) return;
  world_.stats_.islands = genphys::CountIslands(world_.scene_, world_.layer_, world_.joint_index_, rows_);
}

// Who falls asleep at the end of the step was in a lane of it. The contacts of a world that rests are those of a step
// that is long over.
void StepRun::FillStats(size_t fell_asleep) {
  if (!world_.record_stats_) return;
  StepStats& stats = world_.stats_;
  const auto asleep = std::count(state_.asleep.begin(), state_.asleep.end(), uint8_t{1});
  stats.entities_asleep = static_cast<uint32_t>(static_cast<size_t>(asleep) - fell_asleep);
  stats.entities_in_flight = static_cast<uint32_t>(flyers_.size());
  stats.entities_in_engine = static_cast<uint32_t>(rows_.size() - flyers_.size());
  if (!ran_) return;
  stats.pairs = static_cast<uint32_t>(world_.contacts_.pairs.size());
  stats.contacts = static_cast<uint32_t>(world_.contacts_.points.size());
}

}  // namespace genphys

#include "step/step_undo.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "pairs/near_pairs.h"
#include "step/step_scratch.h"

namespace genphys {

StepUndo::StepUndo(World& world)
    : world_(world),
      last_substep_(world.layer_.last_substep),
      contacts_stale_(world.contacts_stale_),
      stirred_rows_(world.stirred_) {
  world.undo_ = this;
}

void StepUndo::Keep(EntityRow entity) {
  const StateArrays& state = world_.state_;
  const LayerState& layer = world_.layer_;
  const uint32_t row = Index(entity);
  rows_.push_back({.row = entity,
                   .pose = state.pose(entity),
                   .linear_velocity = state.linear_velocities.col(row),
                   .angular_velocity = state.angular_velocities.col(row),
                   .asleep = state.asleep[row] != 0,
                   .faulted = layer.faulted[row] != 0,
                   .rest_time = layer.rest_times[row],
                   .half = layer.half_steps[row]});
}

void StepUndo::KeepPassages() {
  if (!passages_) passages_ = world_.layer_.passages;
}

void StepUndo::KeepForces() {
  if (!forces_) forces_ = world_.layer_.forces;
}

// The buffer changes hands, so that nothing is copied.
void StepUndo::KeepSolved() {
  if (std::exchange(has_solved_, true)) return;
  std::swap(world_.scratch_->solved_before, world_.solved_);
}

void StepUndo::Undo() {
  world_.undo_ = nullptr;
  const bool had_engine = world_.engine_ != nullptr;
  if (world_.near_ != nullptr) world_.near_->CancelDrift();
  if (has_solved_) {
    std::swap(world_.scratch_->solved_before, world_.solved_);
  }
  if (is_engine_spoilt_) world_.engine_.reset();
  if (passages_) world_.layer_.passages = *std::move(passages_);
  if (forces_) world_.layer_.forces = *std::move(forces_);
  for (auto saved = rows_.rbegin(); saved != rows_.rend(); ++saved) PutBack(*saved);
  for (auto& [row, touches] : touches_) world_.layer_.last_touches[Index(row)] = std::move(touches);
  LayStirred();
  world_.layer_.last_substep = last_substep_;
  world_.woken_.clear();
  world_.roused_.clear();
  world_.aftermath_ = {};
  if (had_engine) is_engine_spoilt_ ? world_.RebuildEngine(finds_contacts_) : FindContacts();
  for (const EntityRow row : unsettled_) world_.unsettled_.Unmark(row);
  for (const EntityRow row : let_go_) world_.let_go_.Unmark(row);
  // They are only to be looked for.
  world_.stirred_.Add(stirred_rows_);
  world_.is_stirred_ = true;
}

void StepUndo::PutBack(const Row& saved) {
  StateArrays& state = world_.state_;
  LayerState& layer = world_.layer_;
  const uint32_t row = Index(saved.row);
  const bool has_moved = state.pose(saved.row) != saved.pose ||
                         state.linear_velocities.col(row) != saved.linear_velocity ||
                         state.angular_velocities.col(row) != saved.angular_velocity;
  state.set_pose(saved.row, saved.pose);
  state.linear_velocities.col(row) = saved.linear_velocity;
  state.angular_velocities.col(row) = saved.angular_velocity;
  state.asleep[row] = saved.asleep;
  layer.faulted[row] = saved.faulted;
  layer.rest_times[row] = saved.rest_time;
  // What an engine has solved is more exact than the columns made of it, which it need not be told.
  if (has_moved) world_.TellPose(saved.row);
  world_.UpdateActive(saved.row);
  layer.half_steps[row] = saved.half;
}

// Those as of the end of the step before, if nothing has changed since.
void StepUndo::FindContacts() {
  world_.contacts_stale_ = contacts_stale_;
  if (!has_lost_contacts_) return;
  world_.contacts_.Clear();
  if (!finds_contacts_) world_.contacts_stale_ = true;
  if (world_.contacts_stale_) return;
  try {
    world_.near_->Collide(world_.rule_, *world_.engine_, world_.contacts_);
  } catch (const BudgetExceeded&) {
    world_.contacts_.Clear();
    world_.contacts_stale_ = true;
  }
}

void StepUndo::LayStirred() {
  if (stirred_.empty()) return;
  std::ranges::sort(stirred_);
  LayerState& layer = world_.layer_;
  std::erase_if(layer.touching, [&](const TouchingPair& pair) { return std::ranges::binary_search(stirred_, pair); });
  for (const TouchingPair& pair : stirred_) layer.lying.Insert(pair);
}

}  // namespace genphys

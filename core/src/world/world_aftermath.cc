// What a batch of commands leaves to be done once for all of them. Each of many would otherwise look by itself through
// all that the world has of something: what touches, what is asleep, forces and fields. A step leaves some too.
#include <algorithm>
#include <span>
#include <utility>
#include <variant>

#include "genphys/backend.h"
#include "genphys/bounds.h"
#include "genphys/world.h"
#include "pairs/contact_points.h"
#include "pairs/near_pairs.h"
#include "pairs/sleeper_tree.h"
#include "step/sleeping.h"
#include "step/step_undo.h"

namespace genphys {
namespace {

void Order(std::vector<EntityId>& ids) {
  std::ranges::sort(ids);
  const auto same = std::ranges::unique(ids);
  ids.erase(same.begin(), same.end());
}

}  // namespace

// The forces that act on the entity now will do so no more; later ones will.
void World::Unforce(EntityId id) {
  if (!layer_.forces.empty()) aftermath_.forceless[id] = layer_.forces.size();
}

void World::WakeIslandOf(EntityRow row) {
  // Of who sleeps Wake() keeps all that it changes, once.
  if (state_.asleep[Index(row)]) return aftermath_.stirred.push_back(row);
  if (undo_ != nullptr) undo_->Keep(row);
  layer_.rest_times[Index(row)] = 0;
}

void World::Unsettle(EntityRow row) {
  if (unsettled_[row]) return;
  if (undo_ != nullptr) undo_->Unsettled(row);
  unsettled_.Mark(row);
}

void World::UnsettleAndWake(EntityRow row) {
  Unsettle(row);
  WakeIslandOf(row);
}

// What no contact moves, a floor for instance, was not held: many others may lie on it.
void World::LetGo(EntityRow row) {
  WakeIslandOf(row);
  if (!scene_.entities[Index(row)]->traits.is_dynamic) return;
  Unsettle(row);
  if (let_go_[row]) return;
  if (undo_ != nullptr) undo_->HasLetGo(row);
  let_go_.Mark(row);
}

// Who touches it or hangs on it.
void World::WakeNeighboursOf(EntityRow row) {
  aftermath_.displaced.push_back(state_.ids[Index(row)]);
  if (!scene_.force_fields.empty()) aftermath_.pushed.push_back(state_.ids[Index(row)]);
  for (const uint32_t slot : joint_index_.Of(row)) {
    const JointDesc& joint = scene_.joints[slot]->desc;
    const EntityRow a = RowOf(joint.entity_a), b = RowOf(joint.entity_b);
    const EntityRow other = a == row ? b : a;
    if (other != kWorldRow) LetGo(other);
  }
}

// Who sleeps in its bounds; a plane has none. Of what rests there, most may have nothing to sleep from: a batch that
// has looked at as many as the world has rows looks among sleepers alone from then on.
void World::WakeWhereItIs(EntityRow row) {
  if (near_ == nullptr) return WakeAll();
  for (const GeometryRow own : geometry_rows_[Index(row)]) {
    const auto [geometry, placement] = Placed(own);
    if (std::holds_alternative<Plane>(geometry->shape)) return WakeAll();
    const Bounds bounds = BoundsOf(geometry->shape, placement).Widened(kContactGapMax);
    const auto wake = [&](GeometryRow other) {
      const EntityRow entity = rule_.info(other).entity;
      const bool wakes = state_.asleep[Index(entity)] && rule_.Decide(own, other) != PairRule::Verdict::kIgnore;
      if (wakes) WakeIslandOf(entity);
      return wakes;
    };
    if (aftermath_.sleepers == nullptr && aftermath_.looks > state_.rows()) GatherSleepers();
    if (aftermath_.sleepers != nullptr) {
      aftermath_.sleepers->TakeFrom(bounds, wake);
      continue;
    }
    near_->VisitOthers(rule_, own, bounds, [&](GeometryRow other) {
      ++aftermath_.looks;
      wake(other);
    });
  }
}

// Nobody falls asleep until the batch is done, and who is moved or changed meanwhile wakes.
void World::GatherSleepers() {
  aftermath_.sleepers = std::make_shared<SleeperTree>();
  for (uint32_t row = 0; row < state_.rows(); ++row) {
    if (!state_.asleep[row]) continue;
    for (const GeometryRow geometry : geometry_rows_[row]) {
      aftermath_.sleepers->Add(geometry, near_->BoundsOf(geometry));
    }
  }
}

void World::SettleAftermath() {
  for (auto* ids : {&aftermath_.displaced, &aftermath_.detached, &aftermath_.reshaped, &aftermath_.pushed,
                    &aftermath_.deleted, &aftermath_.unsampled}) {
    Order(*ids);
  }
  EndTouches();
  DropSolved();
  DropForces();
  DropSamples();
  if (!aftermath_.pushed.empty()) WakeSprung();
  if (!aftermath_.deleted.empty()) EndFieldsOfDeleted();
  WakeStirred();
  aftermath_.displaced.clear();
  aftermath_.detached.clear();
  aftermath_.reshaped.clear();
  aftermath_.pushed.clear();
  aftermath_.deleted.clear();
  aftermath_.sleepers.reset();
  aftermath_.looks = 0;
}

void World::EndTouches() {
  if (aftermath_.displaced.empty()) return;  // whoever was detached is there too
  const auto left = [&](EntityId id) { return std::ranges::binary_search(aftermath_.displaced, id); };
  const auto is_detached = [&](EntityId id) { return std::ranges::binary_search(aftermath_.detached, id); };
  const auto let_go = [&](EntityId id) {
    if (state_.ids[id.index()] == id) LetGo(EntityRow{id.index()});
  };
  // Taken off and put back with other surfaces, it holds who touches it in another way.
  const auto is_changed = [&](EntityId id) {
    return is_detached(id) && state_.ids[id.index()] == id && layer_.half_steps[id.index()].restarts;
  };
  const auto restart = [&](EntityId id) {
    if (state_.ids[id.index()] == id) layer_.half_steps[id.index()].RestartNowAndThen();
  };
  // Who was only made heavier, say, goes on touching, unless the next step finds that the two parted.
  const auto may_touch = [&](EntityId id) {
    return state_.ids[id.index()] == id && !std::ranges::binary_search(aftermath_.reshaped, id);
  };
  const auto is_over = [&](const TouchingPair& touching) {
    const auto& [a, b] = touching.pair;
    if (!is_detached(a) && !is_detached(b)) return false;
    const auto verdict = touching.is_sensor ? PairRule::Verdict::kSensor : PairRule::Verdict::kCollide;
    const auto meets = [&](GeometryRow own) {
      return std::ranges::any_of(geometry_rows_[b.index()],
                                 [&](GeometryRow other) { return rule_.Decide(own, other) == verdict; });
    };
    return !(may_touch(a) && may_touch(b) && std::ranges::any_of(geometry_rows_[a.index()], meets));
  };
  std::vector<TouchingPair> ended;
  const auto leave = [&](const TouchingPair& touching) {
    const auto& [a, b] = touching.pair;
    if (left(a)) let_go(b);
    if (left(b)) let_go(a);
    if (is_changed(a)) restart(b);
    if (is_changed(b)) restart(a);
    if (is_over(touching)) ended.push_back(touching);
  };
  for (const EntityId id : aftermath_.displaced) layer_.lying.VisitOf(id, leave);
  for (const TouchingPair& touching : ended) layer_.lying.Erase(touching);
  const size_t lying = ended.size();
  for (const TouchingPair& touching : layer_.touching) leave(touching);
  if (ended.size() > lying) std::erase_if(layer_.touching, is_over);
  std::ranges::sort(ended);
  // Of two that both left, each was looked for.
  const auto twice = std::ranges::unique(ended);
  ended.erase(twice.begin(), twice.end());
  for (const TouchingPair& touching : ended) RecordEnd(touching);
}

// Of whom is gone, or others than he was, the last solve tells nothing more.
void World::DropSolved() {
  if (aftermath_.detached.empty() || solved_.pairs.empty()) return;
  std::vector<EntityRow> gone;
  for (const EntityId id : aftermath_.detached) gone.push_back(EntityRow{id.index()});
  std::ranges::sort(gone);
  const auto is_gone = [&](EntityRow row) { return std::ranges::binary_search(gone, row); };
  ContactBuffer kept;
  for (ContactPair pair : solved_.pairs) {
    if (is_gone(pair.entity_a) || is_gone(pair.entity_b)) continue;
    const std::span<const ContactPoint> points = PointsOf(solved_, pair);
    const auto first = static_cast<uint32_t>(kept.points.size());
    kept.points.insert(kept.points.end(), points.begin(), points.end());
    for (SolvedPoint turned : TurnedOf(solved_, pair)) {
      turned.point += first - pair.first_point;
      kept.turned.push_back(turned);
    }
    pair.first_point = first;
    kept.pairs.push_back(pair);
  }
  solved_ = std::move(kept);
}

void World::RecordEnd(const TouchingPair& touching) {
  const EventKinds& kinds = scene_.world.recorded_events;
  const auto& [a, b] = touching.pair;
  if (!touching.is_sensor && kinds.contacts) Record(ContactEnded{touching.pair});
  if (touching.is_sensor && kinds.sensors) {
    Record(touching.a_is_sensor ? SensorLeft{a, b} : SensorLeft{b, a});
  }
}

void World::DropForces() {
  if (aftermath_.forceless.empty()) return;
  std::vector<PendingForce> kept;
  kept.reserve(layer_.forces.size());
  for (size_t i = 0; i < layer_.forces.size(); ++i) {
    const auto forceless = aftermath_.forceless.find(layer_.forces[i].id);
    if (forceless == aftermath_.forceless.end() || i >= forceless->second) kept.push_back(layer_.forces[i]);
  }
  layer_.forces = std::move(kept);
  aftermath_.forceless.clear();
}

void World::DropSamples() {
  if (aftermath_.unsampled.empty()) return;
  std::erase_if(layer_.samples, [&](const SampledForce& sample) {
    return std::ranges::binary_search(aftermath_.unsampled, sample.id);
  });
  aftermath_.unsampled.clear();
}

void World::WakeStirred() {
  if (aftermath_.stirred.empty()) return;
  for (const EntityRow sleeper :
       SleepingIslands(scene_, state_, layer_, joint_index_, aftermath_.stirred, sleepers_found_)) {
    Wake(sleeper);
  }
  aftermath_.stirred.clear();
}

}  // namespace genphys

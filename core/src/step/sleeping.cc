#include "step/sleeping.h"

#include <algorithm>
#include <array>
#include <utility>

#include "motion/running_surfaces.h"
#include "pairs/disjoint_sets.h"
#include "step/resting.h"

namespace genphys {
namespace {

const BodyTraits& TraitsOf(const Scene& scene, uint32_t row) { return scene.entities[row]->traits; }

bool IsDynamic(const Scene& scene, uint32_t row) { return scene.entities[row] && TraitsOf(scene, row).is_dynamic; }

// Whether it moves and whether it turns.
std::array<bool, 2> Motions(const StateArrays& state, uint32_t row, const BodyTraits& traits) {
  return {state.linear_velocities.col(row).norm() > traits.rest_speed,
          state.angular_velocities.col(row).norm() > traits.rest_spin};
}

// Calls `visit(row_a, row_b)` for every spring between two entities.
template <typename Visit>
void ForEachSpring(const Scene& scene, Visit visit) {
  for (const auto& [id, field] : scene.force_fields) {
    const auto* spring = std::get_if<SpringField>(&field.kind);
    if (spring != nullptr && !spring->a.is_null() && !spring->b.is_null()) visit(spring->a.index(), spring->b.index());
  }
}

bool IsHeld(const SceneJoint& joint, const LayerState& layer) {
  const auto is_gone = [&](const EntityRef& entity) { return !entity.is_world() && layer.faulted[entity.id.index()]; };
  return !is_gone(joint.desc.entity_a) && !is_gone(joint.desc.entity_b);
}

// Whom the joint makes restless: whoever hangs on something that moves, or is driven.
template <typename Join, typename Disturb>
void VisitJoint(const Scene& scene, const SceneJoint& joint, const RowSet& active, Join join, Disturb disturb) {
  const JointDesc& desc = joint.desc;
  const bool is_driven = IsDriven(desc.kind);
  const auto is_dynamic = [&](const EntityRef& e) { return !e.is_world() && IsDynamic(scene, e.id.index()); };
  const bool dynamic_a = is_dynamic(desc.entity_a), dynamic_b = is_dynamic(desc.entity_b);
  if (dynamic_a && dynamic_b) join(desc.entity_a.id.index(), desc.entity_b.id.index());
  const auto visit = [&](const EntityRef& entity, const EntityRef& other) {
    const bool is_carried = !other.is_world() && !IsDynamic(scene, other.id.index()) && active[other.id.index()];
    if (is_driven || is_carried) disturb(entity.id.index());
  };
  if (dynamic_a) visit(desc.entity_a, desc.entity_b);
  if (dynamic_b) visit(desc.entity_b, desc.entity_a);
}

}  // namespace

std::vector<EntityRow> RowsToSleep(const Scene& scene, const std::vector<EntityRow>& rows, const JointIndex& joints,
                                   const RowSet& active, const LayerState& layer, RowValues<int>& places) {
  const auto has_rested = [&](EntityRow row) { return HasRested(scene, layer, Index(row)); };
  if (std::ranges::none_of(rows, has_rested)) return {};

  places.Clear();
  for (size_t i = 0; i < rows.size(); ++i) places[rows[i]] = static_cast<int>(i);
  const auto place_of = [&](uint32_t row) { return std::as_const(places)[EntityRow{row}]; };
  DisjointSets islands(rows.size());
  std::vector<uint8_t> restless(rows.size());
  for (size_t i = 0; i < rows.size(); ++i) restless[i] = !has_rested(rows[i]);
  const auto join = [&](uint32_t a, uint32_t b) {
    if (place_of(a) >= 0 && place_of(b) >= 0) {
      islands.Join(static_cast<uint32_t>(place_of(a)), static_cast<uint32_t>(place_of(b)));
    }
  };
  const auto disturb = [&](uint32_t row) {
    if (place_of(row) >= 0) restless[static_cast<size_t>(place_of(row))] = true;
  };
  const auto run = [&](uint32_t row, uint32_t other) {
    const auto& body = scene.entities[other]->desc->rigid_body;
    if (body && HasRunningSurface(*body)) disturb(row);
  };
  const auto tie = [&](uint32_t a, uint32_t b) {
    const bool dynamic_a = IsDynamic(scene, a), dynamic_b = IsDynamic(scene, b);
    if (dynamic_a && dynamic_b) {
      join(a, b);
    } else if (active[dynamic_a ? b : a]) {
      disturb(dynamic_a ? a : b);  // it lies on something that moves
    }
  };
  for (const TouchingPair& touching : layer.touching) {
    if (touching.is_sensor) continue;
    const uint32_t a = touching.pair.a.index(), b = touching.pair.b.index();
    tie(a, b);
    run(a, b);
    run(b, a);
  }
  for (const EntityRow row : rows) {
    for (const uint32_t slot : joints.Of(row)) {
      const SceneJoint& joint = *scene.joints[slot];
      if (IsHeld(joint, layer)) VisitJoint(scene, joint, active, join, disturb);
    }
  }
  ForEachSpring(scene, tie);
  for (uint32_t i = 0; i < rows.size(); ++i) {
    if (restless[i]) restless[islands.Find(i)] = true;
  }
  std::vector<EntityRow> sleepers;
  for (uint32_t i = 0; i < rows.size(); ++i) {
    if (!restless[islands.Find(i)]) sleepers.push_back(rows[i]);
  }
  return sleepers;
}

uint32_t CountIslands(const Scene& scene, const LayerState& layer, const JointIndex& joints,
                      const std::vector<EntityRow>& rows) {
  std::vector<uint8_t> counted(scene.entities.size());
  for (const EntityRow row : rows) counted[Index(row)] = true;
  DisjointSets islands(counted.size());
  auto count = static_cast<uint32_t>(rows.size());
  const auto tie = [&](uint32_t a, uint32_t b) {
    if (!counted[a] || !counted[b] || islands.Find(a) == islands.Find(b)) return;
    islands.Join(a, b);
    --count;
  };
  for (const TouchingPair& touching : layer.touching) {
    if (!touching.is_sensor) tie(touching.pair.a.index(), touching.pair.b.index());
  }
  for (const EntityRow row : rows) {
    for (const uint32_t slot : joints.Of(row)) {
      const JointDesc& desc = scene.joints[slot]->desc;
      if (!desc.entity_a.is_world() && !desc.entity_b.is_world()) {
        tie(desc.entity_a.id.index(), desc.entity_b.id.index());
      }
    }
  }
  return count;
}

void ReportMoving(const Scene& scene, const StateArrays& state, const std::vector<EntityRow>& rows, LayerState& layer,
                  std::vector<EventKind>& events) {
  for (EntityRow entity : rows) {
    const uint32_t row = Index(entity);
    const std::array<bool, 2> moves = Motions(state, row, TraitsOf(scene, row));
    for (const bool rotation : {false, true}) {
      const uint8_t bit = rotation ? 2 : 1;
      if (moves[rotation] == ((layer.moving[row] & bit) != 0)) continue;
      layer.moving[row] ^= bit;
      if (moves[rotation]) {
        events.push_back(EntityStartedMoving{state.ids[row], rotation});
      } else {
        events.push_back(EntityStoppedMoving{state.ids[row], rotation});
      }
    }
  }
}

std::vector<EntityRow> SleepingIslands(const Scene& scene, const StateArrays& state, const LayerState& layer,
                                       const JointIndex& joints, std::span<const EntityRow> rows, RowMarks& found) {
  const auto sleeps = [&](uint32_t r) { return state.asleep[r] && !layer.faulted[r] && IsDynamic(scene, r); };
  // What has no list of those that it ties one body to.
  std::vector<std::pair<uint32_t, uint32_t>> loose;
  const auto tie = [&](uint32_t a, uint32_t b) {
    if (sleeps(a) && sleeps(b)) loose.insert(loose.end(), {{a, b}, {b, a}});
  };
  for (const TouchingPair& touching : layer.touching) {
    if (!touching.is_sensor) tie(touching.pair.a.index(), touching.pair.b.index());
  }
  ForEachSpring(scene, tie);
  std::ranges::sort(loose);

  std::vector<EntityRow> sleepers;
  found.Resize(state.rows());
  found.Clear();
  const auto find = [&](uint32_t r) {
    if (!sleeps(r) || found[EntityRow{r}]) return;
    found.Mark(EntityRow{r});
    sleepers.push_back(EntityRow{r});
  };
  for (const EntityRow row : rows) find(Index(row));
  // Who is found last is at the end of the list.
  for (size_t i = 0; i < sleepers.size(); ++i) {
    const uint32_t r = Index(sleepers[i]);
    layer.lying.VisitOf(state.ids[r], [&](const TouchingPair& touching) {
      const uint32_t a = touching.pair.a.index(), b = touching.pair.b.index();
      if (!touching.is_sensor) find(a == r ? b : a);
    });
    for (const uint32_t slot : joints.Of(EntityRow{r})) {
      const JointDesc& joint = scene.joints[slot]->desc;
      for (const EntityRef& side : {joint.entity_a, joint.entity_b}) {
        if (!side.is_world()) find(side.id.index());
      }
    }
    for (const auto& tied : std::ranges::equal_range(loose, r, {}, &std::pair<uint32_t, uint32_t>::first)) {
      find(tied.second);
    }
  }
  std::ranges::sort(sleepers);
  return sleepers;
}

}  // namespace genphys

#include "sleeping.h"

#include <algorithm>
#include <array>

#include "disjoint_sets.h"
#include "resting.h"
#include "running_surfaces.h"

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
void VisitJoint(const Scene& scene, const SceneJoint& joint, const RowSet& active, DisjointSets& islands,
                std::vector<uint8_t>& restless) {
  const JointDesc& desc = joint.desc;
  const bool is_driven = IsDriven(desc.kind);
  const auto is_dynamic = [&](const EntityRef& e) { return !e.is_world() && IsDynamic(scene, e.id.index()); };
  const bool dynamic_a = is_dynamic(desc.entity_a), dynamic_b = is_dynamic(desc.entity_b);
  if (dynamic_a && dynamic_b) islands.Join(desc.entity_a.id.index(), desc.entity_b.id.index());
  const auto disturb = [&](const EntityRef& entity, const EntityRef& other) {
    const bool is_carried = !other.is_world() && !IsDynamic(scene, other.id.index()) && active[other.id.index()];
    if (is_driven || is_carried) restless[entity.id.index()] = true;
  };
  if (dynamic_a) disturb(desc.entity_a, desc.entity_b);
  if (dynamic_b) disturb(desc.entity_b, desc.entity_a);
}

}  // namespace

std::vector<EntityRow> RowsToSleep(const Scene& scene, const StateArrays& state, const std::vector<EntityRow>& rows,
                                   const JointIndex& joints, const RowSet& active, const LayerState& layer) {
  const auto has_rested = [&](EntityRow row) { return HasRested(scene, layer, Index(row)); };
  if (std::ranges::none_of(rows, has_rested)) return {};

  DisjointSets islands(state.rows());
  std::vector<uint8_t> restless(state.rows());
  for (EntityRow row : rows) restless[Index(row)] = !has_rested(row);
  const auto disturb = [&](uint32_t row, uint32_t other) {
    const auto& body = scene.entities[other]->desc->rigid_body;
    if (body && HasRunningSurface(*body)) restless[row] = true;
  };
  const auto tie = [&](uint32_t a, uint32_t b) {
    const bool dynamic_a = IsDynamic(scene, a), dynamic_b = IsDynamic(scene, b);
    if (dynamic_a && dynamic_b) {
      islands.Join(a, b);
    } else if (active[dynamic_a ? b : a]) {
      restless[dynamic_a ? a : b] = true;  // it lies on something that moves
    }
  };
  for (const TouchingPair& touching : layer.touching) {
    if (touching.is_sensor) continue;
    const uint32_t a = touching.pair.a.index(), b = touching.pair.b.index();
    tie(a, b);
    if (IsDynamic(scene, a)) disturb(a, b);
    if (IsDynamic(scene, b)) disturb(b, a);
  }
  for (const EntityRow row : rows) {
    for (const uint32_t slot : joints.Of(row)) {
      const SceneJoint& joint = *scene.joints[slot];
      if (IsHeld(joint, layer)) VisitJoint(scene, joint, active, islands, restless);
    }
  }
  ForEachSpring(scene, tie);
  for (EntityRow row : rows) {
    if (restless[Index(row)]) restless[islands.Find(Index(row))] = true;
  }
  std::vector<EntityRow> sleepers;
  for (EntityRow row : rows) {
    if (!restless[islands.Find(Index(row))]) sleepers.push_back(row);
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
                                       std::span<const EntityRow> rows) {
  const auto sleeps = [&](uint32_t r) { return state.asleep[r] && !layer.faulted[r] && IsDynamic(scene, r); };
  DisjointSets islands(state.rows());
  const auto tie = [&](uint32_t a, uint32_t b) {
    if (sleeps(a) && sleeps(b)) islands.Join(a, b);
  };
  for (const std::vector<TouchingPair>* pairs : {&layer.touching, &layer.lying}) {
    for (const TouchingPair& touching : *pairs) {
      if (!touching.is_sensor) tie(touching.pair.a.index(), touching.pair.b.index());
    }
  }
  for (const std::optional<SceneJoint>& joint : scene.joints) {
    if (!joint || joint->desc.entity_a.is_world() || joint->desc.entity_b.is_world()) continue;
    tie(joint->desc.entity_a.id.index(), joint->desc.entity_b.id.index());
  }
  ForEachSpring(scene, tie);
  std::vector<uint8_t> is_chosen(state.rows());
  for (const EntityRow row : rows) is_chosen[islands.Find(Index(row))] = true;
  std::vector<EntityRow> sleepers;
  for (uint32_t r = 0; r < state.rows(); ++r) {
    if (sleeps(r) && is_chosen[islands.Find(r)]) sleepers.push_back(EntityRow{r});
  }
  return sleepers;
}

}  // namespace genphys

// How commands change the force fields of a world. All were validated before, so nothing here can fail.
#include <algorithm>
#include <iterator>
#include <utility>

#include "genphys/bounds.h"
#include "genphys/world.h"
#include "motion/field_forces.h"

namespace genphys {
namespace {

// Whom a field names by itself.
EntityPair PairOf(const ForceField& field) {
  const auto* spring = std::get_if<SpringField>(&field.kind);
  return spring != nullptr ? EntityPair{spring->a, spring->b} : EntityPair{};
}

template <typename Kind>
EventKind Told(ForceFieldId id, const ForceField& field) {
  return Kind{id, PairOf(field), std::make_shared<const ForceField>(field)};
}

}  // namespace

EntityId World::CreateField(const CreateForceField& command, std::span<const CreatedId> created) {
  const ForceFieldId id = layer_.next_force_field++;
  ForceField field = command.field;
  for (const uint32_t place : command.created_by_commands) field.entities.push_back(created[place]);
  if (auto* spring = std::get_if<SpringField>(&field.kind)) {
    if (command.spring_a_created_by_command) spring->a = created[*command.spring_a_created_by_command];
    if (command.spring_b_created_by_command) spring->b = created[*command.spring_b_created_by_command];
  }
  SetField(id, std::move(field));
  if (scene_.world.recorded_events.changes) Record(Told<ForceFieldCreated>(id, scene_.force_fields[id]));
  return EntityId::FromPacked(id);
}

void World::UpdateField(const UpdateForceField& command) {
  SetField(command.id, command.field);
  if (scene_.world.recorded_events.changes) {
    Record(Told<ForceFieldUpdated>(command.id, scene_.force_fields[command.id]));
  }
}

void World::DeleteField(ForceFieldId id) {
  const auto entry = scene_.force_fields.find(id);
  const ForceField gone = std::move(entry->second);
  scene_.force_fields.erase(entry);
  Disturb(gone);
  if (scene_.world.recorded_events.changes) Record(ForceFieldDeleted{id, PairOf(gone)});
}

void World::SetField(ForceFieldId id, ForceField field) {
  std::sort(field.entities.begin(), field.entities.end());
  if (auto* fluid = std::get_if<BuoyancyField>(&field.kind)) fluid->surface_normal.normalize();
  const auto before = scene_.force_fields.find(id);
  if (before != scene_.force_fields.end()) Disturb(before->second);
  Disturb(scene_.force_fields[id] = std::move(field));
}

// On whom the field acts: forces that came or went change from now on, not from the middle of the last substep on, and
// nobody sleeps through that.
void World::Disturb(const ForceField& field) {
  FieldForces::Reach reach;
  reach.Add(field);
  DisturbAll(reach.tied);
  for (const std::span<const EntityId> listed : reach.listed) DisturbAll(listed);
  if (!reach.is_everywhere && reach.regions.empty()) return;
  const auto is_reached = [&](uint32_t row) {
    if (reach.is_everywhere) return true;
    const Vector3 center = state_.pose(EntityRow{row}).Transform(scene_.entities[row]->mass.center_of_mass);
    return reach.regions.front().Contains({center, center});
  };
  for (uint32_t row = 0; row < state_.rows(); ++row) {
    if (!(active_[row] || state_.asleep[row]) || !is_reached(row)) continue;
    layer_.half_steps[row].Restart();
    if (state_.asleep[row]) WakeIslandOf(EntityRow{row});
  }
}

void World::DisturbAll(std::span<const EntityId> ids) {
  for (const EntityId id : ids) {
    if (id.is_null() || state_.ids[id.index()] != id) continue;
    layer_.half_steps[id.index()].Restart();
    WakeIslandOf(EntityRow{id.index()});
  }
}

// At either end of a spring of which one was pushed or put elsewhere.
void World::WakeSprung() {
  const auto was_pushed = [&](EntityId id) { return std::ranges::binary_search(aftermath_.pushed, id); };
  for (const auto& [id, field] : scene_.force_fields) {
    const auto* spring = std::get_if<SpringField>(&field.kind);
    if (spring == nullptr || !(was_pushed(spring->a) || was_pushed(spring->b))) continue;
    for (const EntityId end : {spring->a, spring->b}) {
      if (!end.is_null() && state_.ids[end.index()] == end) WakeIslandOf(EntityRow{end.index()});
    }
  }
}

void World::EndFieldsOfDeleted() {
  const auto is_gone = [&](EntityId id) { return std::ranges::binary_search(aftermath_.deleted, id); };
  for (auto entry = scene_.force_fields.begin(); entry != scene_.force_fields.end();) {
    ForceField& field = entry->second;
    const auto* spring = std::get_if<SpringField>(&field.kind);
    const bool is_loose = spring != nullptr && (is_gone(spring->a) || is_gone(spring->b));
    const bool has_lost = std::erase_if(field.entities, is_gone) > 0;
    // With the last of those that a field acted on gone it must not act on all.
    const bool is_over = is_loose || (has_lost && field.entities.empty());
    if (is_loose) Disturb(field);
    if (scene_.world.recorded_events.changes && (is_over || has_lost)) {
      Record(is_over ? EventKind(ForceFieldDeleted{entry->first, PairOf(field)})
                     : Told<ForceFieldUpdated>(entry->first, field));
    }
    entry = is_over ? scene_.force_fields.erase(entry) : std::next(entry);
  }
}

}  // namespace genphys

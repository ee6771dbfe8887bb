// How commands change the force fields of a world. All were validated before, so nothing here can fail.
#include <algorithm>
#include <iterator>
#include <utility>

#include "genphys/world.h"

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
  const EntityPair pair = PairOf(scene_.force_fields[id]);
  scene_.force_fields.erase(id);
  RestartAll();
  WakeAll();
  if (scene_.world.recorded_events.changes) Record(ForceFieldDeleted{id, pair});
}

void World::SetField(ForceFieldId id, ForceField field) {
  std::sort(field.entities.begin(), field.entities.end());
  if (auto* fluid = std::get_if<BuoyancyField>(&field.kind)) fluid->surface_normal.normalize();
  scene_.force_fields[id] = std::move(field);
  RestartAll();
  WakeAll();
}

// Forces that came or went change from now on, not from the middle of the last substep on.
void World::RestartAll() {
  for (HalfStep& half : layer_.half_steps) half.Restart();
}

bool World::HasPushedSpring() const {
  const auto was_pushed = [&](EntityId id) { return std::ranges::binary_search(aftermath_.pushed, id); };
  return std::ranges::any_of(scene_.force_fields, [&](const auto& entry) {
    const auto* spring = std::get_if<SpringField>(&entry.second.kind);
    return spring != nullptr && (was_pushed(spring->a) || was_pushed(spring->b));
  });
}

void World::EndFieldsOfDeleted() {
  const auto is_gone = [&](EntityId id) { return std::ranges::binary_search(aftermath_.deleted, id); };
  bool any_lost = false, any_spring = false;
  for (auto entry = scene_.force_fields.begin(); entry != scene_.force_fields.end();) {
    ForceField& field = entry->second;
    const auto* spring = std::get_if<SpringField>(&field.kind);
    const bool is_loose = spring != nullptr && (is_gone(spring->a) || is_gone(spring->b));
    const bool has_lost = std::erase_if(field.entities, is_gone) > 0;
    // With the last of those that a field acted on gone it must not act on all.
    const bool is_over = is_loose || (has_lost && field.entities.empty());
    any_lost = any_lost || is_over || has_lost;
    any_spring = any_spring || is_loose;
    if (scene_.world.recorded_events.changes && (is_over || has_lost)) {
      Record(is_over ? EventKind(ForceFieldDeleted{entry->first, PairOf(field)})
                     : Told<ForceFieldUpdated>(entry->first, field));
    }
    entry = is_over ? scene_.force_fields.erase(entry) : std::next(entry);
  }
  if (any_lost) RestartAll();
  if (any_spring) WakeAll();
}

}  // namespace genphys

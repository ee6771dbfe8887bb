// What a batch may do to force fields.
#include "commands/command_validator.h"
#include "genphys/limits.h"
#include "genphys/world.h"
#include "model/cat.h"
#include "model/validate.h"

namespace genphys {

// Of an update there is no creation: it names nothing that its batch creates.
Status CommandValidator::CheckSpring(const SpringField& spring, const CreateForceField* creation) const {
  const auto find = [&](EntityId id, const std::optional<uint32_t>& place, std::string_view given,
                        std::string_view field) -> Result<const EntityDesc*> {
    if (!place) return Find(id, field);
    if (*place < made_.size() && made_[*place] != nullptr) return made_[*place].get();
    return Refuse(Reason::kInvalidValue, given,
                  Cat("command ", *place, " of this batch creates no entity before this one"));
  };
  const std::optional<uint32_t> place_a = creation != nullptr ? creation->spring_a_created_by_command : std::nullopt;
  const std::optional<uint32_t> place_b = creation != nullptr ? creation->spring_b_created_by_command : std::nullopt;
  const Result<const EntityDesc*> a = find(spring.a, place_a, "spring_a_created_by_command", "field.spring.entity_a");
  if (!a.ok()) return a.status();
  if (spring.b.is_null() && !place_b) {
    return IsDynamic(**a)
               ? absl::OkStatus()
               : Refuse(Reason::kInvalidValue, "field.spring.entity_a", "a spring needs an entity that it can move");
  }
  const Result<const EntityDesc*> b = find(spring.b, place_b, "spring_b_created_by_command", "field.spring.entity_b");
  if (!b.ok()) return b.status();
  if (*a == *b) {
    return Refuse(Reason::kInvalidValue, "field.spring.entity_b", "a spring holds two different entities");
  }
  return IsDynamic(**a) || IsDynamic(**b)
             ? absl::OkStatus()
             : Refuse(Reason::kInvalidValue, "field.spring.entity_a", "a spring needs an entity that it can move");
}

Status CommandValidator::CheckField(const ForceField& field) const {
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckForceField(field), "field"));
  for (size_t i = 0; i < field.entities.size(); ++i) {
    GENPHYS_RETURN_IF_ERROR(CheckDynamic(field.entities[i], Cat("field.entity_ids[", i, "]")));
  }
  return absl::OkStatus();
}

Status CommandValidator::CheckFieldId(ForceFieldId id, std::string_view field) const {
  if (id == 0) return Refuse(Reason::kMissingField, field, Cat(field, " is not set"));
  const bool exists =
      (world_.scene().force_fields.contains(id) || created_fields_.contains(id)) && !deleted_fields_.contains(id);
  if (exists) return absl::OkStatus();
  return Refuse(Reason::kEntityNotFound, field, Cat("there is no force field ", id));
}

Status CommandValidator::operator()(const CreateForceField& command) {
  if (world_.scene().force_fields.size() + created_fields_.size() >= Limits::kForceFieldsMax) {
    return Refuse(Reason::kLimitExceeded, "field", Cat("a world holds ", Limits::kForceFieldsMax, " force fields"));
  }
  GENPHYS_RETURN_IF_ERROR(CheckField(command.field));
  for (size_t i = 0; i < command.created_by_commands.size(); ++i) {
    const uint32_t place = command.created_by_commands[i];
    const bool is_dynamic = place < made_.size() && made_[place] != nullptr && IsDynamic(*made_[place]);
    if (is_dynamic) continue;
    return Refuse(Reason::kInvalidValue, Cat("created_by_commands[", i, "]"),
                  Cat("command ", place, " of this batch creates no dynamic entity before this one"));
  }
  if (const auto* spring = std::get_if<SpringField>(&command.field.kind)) {
    GENPHYS_RETURN_IF_ERROR(CheckSpring(*spring, &command));
  } else if (command.spring_a_created_by_command || command.spring_b_created_by_command) {
    return Refuse(Reason::kInvalidValue,
                  command.spring_a_created_by_command ? "spring_a_created_by_command" : "spring_b_created_by_command",
                  "only a spring has two ends");
  }
  created_fields_.insert(world_.layer_state().next_force_field + created_fields_.size());
  return absl::OkStatus();
}

Status CommandValidator::operator()(const UpdateForceField& command) {
  GENPHYS_RETURN_IF_ERROR(CheckFieldId(command.id, "field.id"));
  GENPHYS_RETURN_IF_ERROR(CheckField(command.field));
  const auto* spring = std::get_if<SpringField>(&command.field.kind);
  return spring != nullptr ? CheckSpring(*spring, nullptr) : absl::OkStatus();
}

Status CommandValidator::operator()(const DeleteForceField& command) {
  GENPHYS_RETURN_IF_ERROR(CheckFieldId(command.id, "field_id"));
  deleted_fields_.insert(command.id);
  return absl::OkStatus();
}

}  // namespace genphys

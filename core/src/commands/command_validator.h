#pragma once
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "genphys/command.h"
#include "genphys/scene.h"
#include "genphys/status.h"

namespace genphys {

class World;

/// An entity that a command creates or changes: valid, filled in, with what follows from it.
struct PreparedEntity {
  std::shared_ptr<const EntityDesc> desc;
  MassProperties mass;
};

/// About how much work it is to check or to apply one in a world of so many entities, in units of a WorkWatch.
int64_t WorkOf(const Command& command, size_t entities);

/// Checks a batch against the world as the earlier commands of the batch will leave it, so that applying it afterwards
/// cannot fail half-way. Changes nothing.
class CommandValidator {
 public:
  explicit CommandValidator(const World& world) : world_(world), settings_(WorldSettings(world)) {}

  /// OK, or the first refusal with the path commands[i].<command>.<field>. Throws CutShort.
  Status Check(std::span<const Command> commands);

  /// One per CreateEntity and UpdateEntity of the batch, in order.
  std::vector<PreparedEntity>& prepared() { return prepared_; }

 private:
  // Of the world's description, without copying its entities.
  static WorldDesc WorldSettings(const World& world);

  Status operator()(const CreateEntity& command);
  Status operator()(const UpdateEntity& command);
  Status operator()(const DeleteEntity& command);
  Status operator()(const ApplyForce& command);
  Status operator()(const ApplyImpulse& command);
  Status operator()(const SetVelocity& command);
  Status operator()(const SetPose& command);
  Status operator()(const SetGravity& command);
  Status operator()(const SetStepper& command);
  Status operator()(const SetEngine& command);
  Status operator()(const ApplyForceColumns& command);
  Status operator()(const CreateJoint& command);
  Status operator()(const UpdateJoint& command);
  Status operator()(const DeleteJoint& command);
  Status operator()(const SetMotorColumns& command);
  Status operator()(const CreateForceField& command);
  Status operator()(const UpdateForceField& command);
  Status operator()(const DeleteForceField& command);

  /// The entity as the batch leaves it so far, or why `id` names none.
  Result<const EntityDesc*> Find(EntityId id, std::string_view field) const;
  Status CheckDynamic(EntityId id, std::string_view field) const;
  /// Whether `count` more forces may wait for a step.
  Status CheckPending(size_t count, std::string_view field);
  /// Whether the world has room for the geometries of `after`, in place of those of `before` unless that is null.
  Status CheckRoom(const EntityDesc& after, const EntityDesc* before);
  Status Prepare(const EntityDesc& desc, std::string_view path, PreparedEntity& out) const;
  Status CheckIgnored(const EntityDesc& desc) const;
  Status CheckEngine(const std::string& name) const;
  /// The joint as the batch leaves it so far, or why `id` names none.
  Result<JointDesc> Find(JointId id, std::string_view field) const;
  Result<const EntityDesc*> Find(const EntityRef& entity, std::string_view field) const;
  Status CheckEnds(const JointDesc& joint) const;
  Status CheckFeature(const JointKind& kind) const;
  Status CheckMotor(JointId id, double velocity, const double* position) const;
  Status CheckField(const ForceField& field) const;
  Status CheckSpring(const SpringField& spring, const CreateForceField* creation) const;
  Status CheckFieldId(ForceFieldId id, std::string_view field) const;

  const World& world_;
  WorldDesc settings_;
  // What the batch has changed: null once deleted.
  std::map<EntityId, std::shared_ptr<const EntityDesc>> changed_;
  std::map<JointId, std::optional<JointDesc>> changed_joints_;
  std::set<ForceFieldId> created_fields_;
  std::set<ForceFieldId> deleted_fields_;
  uint32_t created_ = 0;
  uint32_t created_joints_ = 0;
  size_t new_forces_ = 0;
  int64_t new_geometries_ = 0;  // less those that go
  std::set<const void*> new_shapes_;
  size_t new_shape_bytes_ = 0;
  std::vector<PreparedEntity> prepared_;
  std::vector<JointKind> kinds_;  // that the batch creates or changes to
  // By place in the batch: what a CreateEntity there makes.
  std::vector<std::shared_ptr<const EntityDesc>> made_;
};

/// `current` with the named fields of `update`.
EntityDesc Merged(const EntityDesc& current, const UpdateEntity& update);

}  // namespace genphys

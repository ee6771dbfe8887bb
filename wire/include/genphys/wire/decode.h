#pragma once
#include <google/protobuf/repeated_ptr_field.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "genphys/command.h"
#include "genphys/event.h"
#include "genphys/ids.h"
#include "genphys/query.h"
#include "genphys/scene.h"
#include "genphys/status.h"
#include "genphys/v1/command.pb.h"
#include "genphys/v1/entity.pb.h"
#include "genphys/v1/event.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"

// From the wire to the model. Requests have passed ValidateLimits() before; what is refused here is what declared
// limits cannot say: features that no engine has, masks that name no field, engines of the wrong form. Field paths
// start inside the argument unless it is said otherwise. Nothing here is unsafe on a message that was not validated.

namespace genphys {

/// MISSING_FIELD when nothing says what it does. Its id is the caller's to look at.
Result<ForceField> DecodeForceField(const v1::ForceField& field);

/// The world asked for; an empty engine is `default_engine` (a short name). Name, request id, state and
/// record_state_hash are the caller's to read.
Result<WorldDesc> DecodeWorld(const v1::World& world, std::string_view default_engine);

/// All commands in order, or the first refusal, whose path starts with "commands[i].".
Result<std::vector<Command>> DecodeCommands(const google::protobuf::RepeatedPtrField<v1::Command>& commands);

/// One command. MISSING_FIELD "kind" when it is unset.
Result<Command> DecodeCommand(const v1::Command& command);

/// The entity to create; the path of a refusal starts inside the entity.
Result<CreateEntity> DecodeCreate(const v1::Entity& entity);

/// The force to apply.
Result<ApplyForce> DecodeForce(const v1::ApplyForce& force);

/// A description: of an entity to create, or of one that the server sent.
Result<EntityDesc> DecodeEntity(const v1::Entity& entity);

/// A joint to make or change, or one that the server sent.
Result<JointDesc> DecodeJoint(const v1::Joint& joint);

/// What a joint is doing.
JointState DecodeJointState(const v1::JointState& state);

/// How time advances, with every default filled in.
StepperDesc DecodeStepper(const v1::Stepper& stepper);

/// The kinds as listed: an unset flag is off.
EventKinds DecodeKinds(const v1::EventKinds& kinds);

/// One event as the server sent it. INVALID_VALUE for a kind that this build does not know.
Result<Event> DecodeEvent(const v1::Event& event);

/// The rays in order. INVALID_VALUE when the columns differ in their number of rows.
Result<std::vector<Ray>> DecodeRays(const v1::CastRaysRequest& request);

/// The hits in order of the rays. INVALID_VALUE when the columns differ in their number of rows.
Result<std::vector<RayHit>> DecodeRayHits(const v1::CastRaysResponse& response);

/// A column of ids; bytes after the last whole row are left out.
std::vector<EntityId> DecodeIds(std::string_view column);

/// "ode" of "engines/ode". INVALID_VALUE "engine" for another form.
Result<std::string> DecodeEngineName(std::string_view name);

}  // namespace genphys

#pragma once
#include <span>
#include <string>
#include <string_view>

#include "genphys/capabilities.h"
#include "genphys/command.h"
#include "genphys/event.h"
#include "genphys/query.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "genphys/v1/command.pb.h"
#include "genphys/v1/engine_service.pb.h"
#include "genphys/v1/entity.pb.h"
#include "genphys/v1/event.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"
#include "genphys/world.h"

// From the model to the wire; encode_frame.h has the frames. Each function sets what it knows of `out`, which is empty
// before.

namespace genphys {

/// The description with its id; what the description leaves unset stays unset.
void EncodeEntity(EntityId id, const EntityDesc& desc, v1::Entity* out);

/// The description with its id; what the description leaves unset stays unset.
void EncodeJoint(JointId id, const JointDesc& desc, v1::Joint* out);

/// What a joint is doing.
void EncodeJointState(JointId id, const JointState& state, v1::JointState* out);

/// What all joints of the world are doing, in ascending order of id, in the scalars that the frame says.
void EncodeJointColumns(const World& world, v1::Frame* out);

/// What happened; without `contact_points` those are left out.
void EncodeEvent(const Event& event, v1::Event* out, bool contact_points = true);

/// The kinds as flags.
void EncodeKinds(const EventKinds& kinds, v1::EventKinds* out);

/// The command that DecodeCommand() reads back.
void EncodeCommand(const Command& command, v1::Command* out);

/// The field with its id, zero for one that has none yet.
void EncodeForceField(ForceFieldId id, const ForceField& field, v1::ForceField* out);

/// How time advances, with nothing left to a default but the preset's own numbers.
void EncodeStepper(const StepperDesc& stepper, v1::Stepper* out);

/// The description of a world. `name` as in "worlds/w"; an empty engine stays empty. record_state_hash is the caller's
/// to set.
void EncodeWorld(const WorldDesc& desc, std::string_view name, v1::World::State state, v1::World* out);

/// Where the work of a step went.
void EncodeStats(const StepStats& stats, v1::StepStats* out);

/// One row per hit; a ray without one has a null id, the fraction 1 and no normal.
void EncodeRayHits(std::span<const RayHit> hits, v1::CastRaysResponse* out);

/// One row per ray.
void EncodeRays(std::span<const Ray> rays, v1::CastRaysRequest* out);

/// What an engine can do.
void EncodeEngine(const Capabilities& capabilities, v1::Engine* out);

/// "engines/ode" of "ode"; empty stays empty.
std::string EncodeEngineName(std::string_view engine);

}  // namespace genphys

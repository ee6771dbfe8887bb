#include "genphys/client/world.h"

#include <utility>

#include "connection.h"
#include "drive_impl.h"
#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "keyframes.h"
#include "requests.h"
#include "streams_impl.h"

namespace genphys::client {
namespace {

using Simulation = v1::SimulationService::Stub;
using Worlds = v1::WorldService::Stub;

constexpr int kPageSize = 1000;
// A handle that goes must not hold its thread up for a server that no longer answers.
constexpr std::chrono::milliseconds kFarewell{2'000};

WorldInfo::State DecodeState(v1::World::State state) {
  switch (state) {
    case v1::World::STATE_PLAYING:
      return WorldInfo::State::kPlaying;
    case v1::World::STATE_FAULTED:
      return WorldInfo::State::kFaulted;
    default:
      return WorldInfo::State::kPaused;
  }
}

}  // namespace

World::World(std::shared_ptr<Connection> connection, std::string name, bool owned)
    : connection_(std::move(connection)),
      name_(std::move(name)),
      owned_(owned),
      keyframes_(std::make_shared<Keyframes>()) {}

World::World(World&& other) noexcept
    : connection_(std::move(other.connection_)),
      name_(std::move(other.name_)),
      owned_(std::exchange(other.owned_, false)),
      keyframes_(std::move(other.keyframes_)) {}

World& World::operator=(World&& other) noexcept {
  std::swap(connection_, other.connection_);
  std::swap(name_, other.name_);
  std::swap(owned_, other.owned_);
  std::swap(keyframes_, other.keyframes_);
  return *this;
}

World::~World() {
  if (!owned_) return;
  v1::DeleteWorldRequest request;
  request.set_name(name_);
  v1::DeleteWorldResponse response;
  (void)connection_->CallOnce(connection_->worlds(), &Worlds::DeleteWorld, request, &response, kFarewell);
}

Result<WorldInfo> World::Info() const {
  v1::GetWorldRequest request;
  request.set_name(name_);
  v1::GetWorldResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->worlds(), &Worlds::GetWorld, request, &response));
  Result<WorldDesc> world = DecodeWorld(response.world(), "");
  if (!world.ok()) return world.status();
  return WorldInfo{*std::move(world), response.world().record_state_hash(), DecodeState(response.world().state()),
                   DecodeStamp(response.stamp())};
}

Status World::Delete() {
  v1::DeleteWorldRequest request;
  request.set_name(name_);
  v1::DeleteWorldResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->CallOnce(connection_->worlds(), &Worlds::DeleteWorld, request, &response));
  owned_ = false;
  return absl::OkStatus();
}

Result<EntityId> World::Add(const Shape& shape, const BodyOptions& options) { return Create(Body(shape, options)); }

Result<EntityId> World::Create(const EntityDesc& entity) {
  v1::CreateEntityRequest request;
  request.set_world(name_);
  request.set_request_id(connection_->NextRequestId());
  EncodeEntity(EntityId(), entity, request.mutable_entity());
  v1::CreateEntityResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::CreateEntity, request, &response));
  return EntityId::FromPacked(response.entity().id());
}

Status World::Remove(EntityId id) {
  v1::DeleteEntityRequest request;
  request.set_world(name_);
  request.set_request_id(connection_->NextRequestId());
  request.set_entity_id(id.packed());
  v1::DeleteEntityResponse response;
  return connection_->Call(connection_->simulation(), &Simulation::DeleteEntity, request, &response);
}

Result<EntityDesc> World::Describe(EntityId id) const {
  v1::GetEntityRequest request;
  request.set_world(name_);
  request.set_entity_id(id.packed());
  v1::GetEntityResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::GetEntity, request, &response));
  return DecodeEntity(response.entity());
}

Result<std::vector<EntityInfo>> World::ListEntities() const {
  std::vector<EntityInfo> entities;
  v1::ListEntitiesRequest request;
  request.set_world(name_);
  request.set_page_size(kPageSize);
  do {
    v1::ListEntitiesResponse response;
    GENPHYS_RETURN_IF_ERROR(
        connection_->Call(connection_->simulation(), &Simulation::ListEntities, request, &response));
    for (const v1::Entity& entity : response.entities()) {
      Result<EntityDesc> desc = DecodeEntity(entity);
      if (!desc.ok()) return desc.status();
      entities.push_back({EntityId::FromPacked(entity.id()), *std::move(desc)});
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return entities;
}

Result<JointId> World::Join(const JointDesc& joint) {
  const Command command = CreateJoint{joint};
  const Result<std::vector<CreatedId>> created = Apply({&command, 1});
  if (!created.ok()) return created.status();
  return JointId(created->front());
}

Status World::UpdateJoint(JointId id, const JointDesc& joint, JointFields fields) {
  return ApplyOne(genphys::UpdateJoint{id, joint, fields});
}

Status World::Unjoin(JointId id) { return ApplyOne(DeleteJoint{id}); }

Result<std::vector<JointInfo>> World::ListJoints() const {
  std::vector<JointInfo> joints;
  v1::ListJointsRequest request;
  request.set_world(name_);
  request.set_page_size(kPageSize);
  do {
    v1::ListJointsResponse response;
    GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::ListJoints, request, &response));
    for (int i = 0; i < response.joints_size(); ++i) {
      Result<JointDesc> desc = DecodeJoint(response.joints(i));
      if (!desc.ok()) return desc.status();
      const JointState state = i < response.states_size() ? DecodeJointState(response.states(i)) : JointState{};
      joints.push_back({JointId::FromPacked(response.joints(i).id()), *std::move(desc), state});
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return joints;
}

Status World::Update(EntityId id, const EntityDesc& entity, EntityFields fields) {
  return ApplyOne(UpdateEntity{id, entity, fields});
}

Result<ForceFieldId> World::AddField(const ForceField& field) {
  const Command command = CreateForceField{field};
  const Result<std::vector<CreatedId>> created = Apply({&command, 1});
  if (!created.ok()) return created.status();
  return created->front().packed();
}

Status World::UpdateField(ForceFieldId id, const ForceField& field) { return ApplyOne(UpdateForceField{id, field}); }

Status World::RemoveField(ForceFieldId id) { return ApplyOne(DeleteForceField{id}); }

Result<std::vector<ForceFieldInfo>> World::ListForceFields() const {
  std::vector<ForceFieldInfo> fields;
  v1::ListForceFieldsRequest request;
  request.set_world(name_);
  request.set_page_size(kPageSize);
  do {
    v1::ListForceFieldsResponse response;
    GENPHYS_RETURN_IF_ERROR(
        connection_->Call(connection_->simulation(), &Simulation::ListForceFields, request, &response));
    for (const v1::ForceField& message : response.fields()) {
      Result<ForceField> field = DecodeForceField(message);
      if (!field.ok()) return field.status();
      fields.push_back({message.id(), *std::move(field)});
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return fields;
}

Status World::ApplyForce(const genphys::ApplyForce& force) {
  v1::Command command;
  EncodeCommand(force, &command);
  v1::ApplyForceRequest request;
  request.set_world(name_);
  request.set_request_id(connection_->NextRequestId());
  *request.mutable_force() = std::move(*command.mutable_apply_force());
  v1::ApplyForceResponse response;
  return connection_->Call(connection_->simulation(), &Simulation::ApplyForce, request, &response);
}

Status World::ApplyImpulse(const genphys::ApplyImpulse& impulse) { return ApplyOne(impulse); }

Status World::SetVelocity(const genphys::SetVelocity& velocity) { return ApplyOne(velocity); }

Status World::SetPose(const genphys::SetPose& pose) { return ApplyOne(pose); }

Status World::SetGravity(const Vector3& gravity) { return ApplyOne(genphys::SetGravity{gravity}); }

Status World::SetStepper(const StepperDesc& stepper) { return ApplyOne(genphys::SetStepper{stepper}); }

Status World::SetEngine(const std::string& engine) { return ApplyOne(genphys::SetEngine{engine}); }

Status World::ApplyOne(Command command) { return Apply({&command, 1}).status(); }

Result<std::vector<CreatedId>> World::Apply(std::span<const Command> commands) {
  v1::StepRequest request;
  request.set_steps(0);
  for (const Command& command : commands) EncodeCommand(command, request.add_commands());
  Result<std::shared_ptr<const v1::StepResponse>> response = CallStep(std::move(request));
  if (!response.ok()) return response.status();
  std::vector<CreatedId> created;
  for (const v1::CommandResult& result : (*response)->results()) {
    created.push_back(EntityId::FromPacked(result.created_id()));
  }
  return created;
}

Result<std::shared_ptr<const v1::StepResponse>> World::CallStep(
    v1::StepRequest request, std::optional<std::chrono::milliseconds> deadline) const {
  request.set_world(name_);
  request.set_request_id(connection_->NextRequestId());
  return connection_->Step(request, deadline);
}

Result<StepResult> World::Step(uint32_t steps, const StepOptions& options) {
  v1::StepRequest request;
  EncodeStep(steps, options, &request);
  const bool deltas = options.frame && options.frame->deltas;
  const FramePtr keyframe = deltas ? keyframes_->Find(request.mutable_frame()) : nullptr;
  const v1::FrameRequest wishes = deltas ? request.frame() : v1::FrameRequest();
  Result<std::shared_ptr<const v1::StepResponse>> response = CallStep(std::move(request), options.deadline);
  if (!response.ok()) return response.status();
  if (deltas) keyframes_->Keep(wishes, FramePtr(*response, &(*response)->frame()));
  return DecodeStep(*std::move(response), keyframe);
}

Drive World::OpenDrive() const { return Drive(std::make_unique<Drive::Impl>(connection_, name_, keyframes_)); }

Status World::Play(double real_time_factor) {
  v1::PlayWorldRequest request;
  request.set_name(name_);
  request.set_real_time_factor(real_time_factor);
  v1::PlayWorldResponse response;
  return connection_->CallOnce(connection_->worlds(), &Worlds::PlayWorld, request, &response);
}

Status World::Pause() {
  v1::PauseWorldRequest request;
  request.set_name(name_);
  v1::PauseWorldResponse response;
  return connection_->CallOnce(connection_->worlds(), &Worlds::PauseWorld, request, &response);
}

Status World::Reset() {
  v1::ResetWorldRequest request;
  request.set_name(name_);
  v1::ResetWorldResponse response;
  return connection_->CallOnce(connection_->worlds(), &Worlds::ResetWorld, request, &response);
}

Result<EventStream> World::WatchEvents(const WatchOptions& options) const {
  v1::WatchEventsRequest request;
  request.set_world(name_);
  EncodeEventOptions(options.events, request.mutable_filter());
  if (options.after) {
    request.set_epoch(options.after->epoch);
    request.set_after_sequence(options.after->sequence);
  }
  auto impl = std::make_unique<EventStream::Impl>(connection_, std::move(request));
  GENPHYS_RETURN_IF_ERROR(impl->Open(connection_->deadline()));
  return EventStream(std::move(impl));
}

Result<FrameStream> World::WatchFrames(const FrameOptions& options, uint32_t every_nth_step) const {
  v1::WatchFramesRequest request;
  request.set_world(name_);
  request.set_every_nth_step(every_nth_step);
  EncodeFrameOptions(options, request.mutable_frame());
  auto impl = std::make_unique<FrameStream::Impl>(connection_, std::move(request));
  GENPHYS_RETURN_IF_ERROR(impl->Open(connection_->deadline()));
  return FrameStream(std::move(impl));
}

}  // namespace genphys::client

#include "hosted_world.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "genphys/work_watch.h"
#include "page_token.h"

namespace genphys {
namespace {

// A refusal of the only command of a batch, told by the path of the request's own field. `inner` is how the command
// names the part that the request has.
Status AboutRequest(const Status& status, std::string_view inner, std::string_view outer) {
  const std::optional<Refusal> refusal = RefusalOf(status);
  if (!refusal || !refusal->field.starts_with(inner)) return status;
  std::string field(outer);
  std::string_view rest = std::string_view(refusal->field).substr(inner.size());
  if (field.empty() && rest.starts_with('.')) rest.remove_prefix(1);
  field += rest;
  return Refuse(refusal->reason, field, MessageOf(status));
}

// Each list has tokens of its own: ids of one mean nothing in another.
constexpr char kEntities = 'e', kJoints = 'j', kForceFields = 'f';

// The place in a list: which list, in which epoch, and after which id.
struct ListPlace {
  char list = 0;
  uint64_t epoch = 0;
  uint64_t id = 0;
};

std::string ToText(const ListPlace& place) {
  return place.list + std::to_string(place.epoch) + ' ' + std::to_string(place.id);
}

std::optional<ListPlace> PlaceOf(std::string_view token) {
  const std::optional<std::string> text = DecodePageToken(token);
  if (!text || text->empty()) return std::nullopt;
  ListPlace place{.list = text->front()};
  const char* const end = text->data() + text->size();
  const auto epoch = std::from_chars(text->data() + 1, end, place.epoch);
  if (epoch.ec != std::errc() || epoch.ptr == end || *epoch.ptr != ' ') return std::nullopt;
  const auto id = std::from_chars(epoch.ptr + 1, end, place.id);
  if (id.ec != std::errc() || id.ptr != end) return std::nullopt;
  return place;
}

// The first `count` of `ids` in ascending order, and one more if there are more.
template <typename Id>
std::vector<Id> FirstOf(std::vector<Id> ids, size_t count) {
  const auto end = ids.begin() + static_cast<std::ptrdiff_t>(std::min(ids.size(), count + 1));
  std::partial_sort(ids.begin(), end, ids.end());
  ids.erase(end, ids.end());
  return ids;
}

std::vector<EntityId> IdsAfter(const StateArrays& state, EntityId after, size_t count) {
  std::vector<EntityId> ids;
  std::copy_if(state.ids.begin(), state.ids.end(), std::back_inserter(ids), [&](EntityId id) { return id > after; });
  return FirstOf(std::move(ids), count);
}

std::vector<JointId> IdsAfter(const Scene& scene, JointId after, size_t count) {
  std::vector<JointId> ids;
  for (const std::optional<SceneJoint>& joint : scene.joints) {
    if (joint && joint->id > after) ids.push_back(joint->id);
  }
  return FirstOf(std::move(ids), count);
}

}  // namespace

Result<std::unique_ptr<HostedWorld>> HostedWorld::Create(const BackendRegistry& registry, WorkerPool& pool,
                                                         const std::string& name, const v1::World& wanted,
                                                         std::string_view default_engine,
                                                         std::function<void()> call_current) {
  const Result<WorldDesc> desc = DecodeWorld(wanted, default_engine);
  if (!desc.ok()) return WithFieldPrefix(desc.status(), "world");
  Result<std::unique_ptr<World>> world = World::Create(registry, *desc);
  if (!world.ok()) return WithFieldPrefix(world.status(), "world");
  return std::unique_ptr<HostedWorld>(
      new HostedWorld(pool, name, *std::move(world), wanted.record_state_hash(), std::move(call_current)));
}

HostedWorld::HostedWorld(WorkerPool& pool, std::string name, std::unique_ptr<World> world, bool record_state_hash,
                         std::function<void()> call_current)
    : name_(std::move(name)),
      record_state_hash_(record_state_hash),
      world_(std::move(world)),
      events_(std::make_shared<EventLog>(pool, stamp())),
      frames_(std::make_shared<FrameHub>(pool, std::move(call_current))),
      summary_(name_, record_state_hash) {
  Publish();
}

Stamp HostedWorld::stamp() {
  if (record_state_hash_ && !state_hash_) state_hash_ = world_->StateHash();
  return {world_->layer_state().step, world_->layer_state().simulation_time, epoch_, state_hash_};
}

v1::World::State HostedWorld::state() const {
  if (faulted()) return v1::World::STATE_FAULTED;
  return pace_ ? v1::World::STATE_PLAYING : v1::World::STATE_PAUSED;
}

void HostedWorld::UpdateSummary() { summary_.Update(*world_, stamp(), state(), rests_at_ && pace_); }

// Who hears of a step and asks where the world is finds it there.
std::shared_ptr<const EventChunk> HostedWorld::PublishEvents() {
  state_hash_.reset();
  std::vector<Event> events = world_->TakeEvents();
  if (events.empty()) return nullptr;
  UpdateSummary();
  auto chunk = std::make_shared<const EventChunk>(stamp(), std::move(events));
  events_->Append(chunk->stamp(), chunk);
  return chunk;
}

std::shared_ptr<const EventChunk> HostedWorld::Publish() {
  auto chunk = PublishEvents();
  if (chunk == nullptr) {
    UpdateSummary();
    events_->Append(stamp(), nullptr);
  }
  if (frames_->HasViewers()) frames_->Publish(*world_, stamp(), keyframes_);
  return chunk;
}

Status HostedWorld::CheckUsable() const {
  if (!faulted()) return absl::OkStatus();
  return Refuse(Reason::kWorldFaulted, "", "the world is faulted: it can be read, reset and deleted");
}

// What a world undid by itself it knows in full; an exception may have left it half way.
Status HostedWorld::CheckReadable() const {
  if (!broken_) return absl::OkStatus();
  return Refuse(Reason::kWorldFaulted, "",
                "the world failed in the middle of a change, so that rays and shapes cannot be trusted to find what is "
                "there: it can be read, reset and deleted");
}

Status HostedWorld::CheckSteppable() const {
  GENPHYS_RETURN_IF_ERROR(CheckUsable());
  if (!pace_) return absl::OkStatus();
  return Refuse(Reason::kWorldNotPaused, "", "the world plays: pause it before it is stepped");
}

Result<std::vector<CreatedId>> HostedWorld::Apply(std::span<const Command> commands) {
  GENPHYS_RETURN_IF_ERROR(CheckUsable());
  // To read what they create may have taken long.
  GENPHYS_RETURN_IF_ERROR(WorkWatch::Ask());
  Result<std::vector<CreatedId>> created = world_->Apply(commands);
  if (created.ok()) keyframes_.FollowCommands(*world_, commands.first(created->size()));
  return created;
}

void HostedWorld::MarkBeginning() {
  if (has_beginning_ || world_->layer_state().step > 0) return;
  world_->MarkBeginning();
  events_->MarkBeginning();
  has_beginning_ = true;
}

void HostedWorld::ForgetBeginning() {
  if (world_->layer_state().step > 0 || world_->faulted()) return;
  world_->ForgetBeginning();
  events_->ForgetBeginning();
  has_beginning_ = false;
}

Status HostedWorld::Step(std::optional<double> step_size) {
  MarkBeginning();
  const Status status = world_->Step(step_size);
  // The first step is still to come, and what commands do until then happens before it.
  if (!status.ok()) ForgetBeginning();
  keyframes_.FollowStep(*world_);
  return status;
}

Result<EntityId> HostedWorld::ApplyOne(Command command, std::string_view inner, std::string_view outer) {
  const Result<std::vector<CreatedId>> created = Apply({&command, 1});
  Publish();
  if (!created.ok()) return AboutRequest(created.status(), inner, outer);
  return created->front();
}

Result<v1::CreateEntityResponse> HostedWorld::CreateEntity(const v1::CreateEntityRequest& request) {
  Result<genphys::CreateEntity> command = DecodeCreate(request.entity());
  if (!command.ok()) return WithFieldPrefix(command.status(), "entity");
  const Result<EntityId> id = ApplyOne(*std::move(command), "commands[0].create_entity", "");
  if (!id.ok()) return id.status();
  v1::CreateEntityResponse response;
  EncodeEntity(*id, *world_->Describe(*id), response.mutable_entity());
  stamp().Encode(response.mutable_stamp());
  return response;
}

Result<v1::DeleteEntityResponse> HostedWorld::DeleteEntity(const v1::DeleteEntityRequest& request) {
  const genphys::DeleteEntity command{EntityId::FromPacked(request.entity_id())};
  const Result<EntityId> done = ApplyOne(command, "commands[0].delete_entity", "");
  if (!done.ok()) return done.status();
  v1::DeleteEntityResponse response;
  stamp().Encode(response.mutable_stamp());
  return response;
}

Result<v1::ApplyForceResponse> HostedWorld::ApplyForce(const v1::ApplyForceRequest& request) {
  const Result<genphys::ApplyForce> command = DecodeForce(request.force());
  if (!command.ok()) return WithFieldPrefix(command.status(), "force");
  const Result<EntityId> done = ApplyOne(*command, "commands[0].apply_force", "force");
  if (!done.ok()) return done.status();
  v1::ApplyForceResponse response;
  stamp().Encode(response.mutable_stamp());
  return response;
}

Result<v1::GetEntityResponse> HostedWorld::GetEntity(const v1::GetEntityRequest& request) {
  const EntityId id = EntityId::FromPacked(request.entity_id());
  const Result<EntityDesc> desc = world_->Describe(id);
  if (!desc.ok()) return desc.status();
  v1::GetEntityResponse response;
  EncodeEntity(id, *desc, response.mutable_entity());
  stamp().Encode(response.mutable_stamp());
  return response;
}

Result<uint64_t> HostedWorld::PlaceIn(char list, const std::string& page_token) const {
  if (page_token.empty()) return uint64_t{0};
  const std::optional<ListPlace> given = PlaceOf(page_token);
  if (given && given->list == list && given->epoch == epoch_) return given->id;
  return Refuse(Reason::kInvalidValue, "page_token",
                "page_token is not of this list: pages go on only until the world is reset");
}

Result<v1::ListEntitiesResponse> HostedWorld::ListEntities(const v1::ListEntitiesRequest& request) {
  const Result<uint64_t> after = PlaceIn(kEntities, request.page_token());
  if (!after.ok()) return after.status();
  const size_t count = PageSize(request.page_size());
  const std::vector<EntityId> ids = IdsAfter(world_->state(), EntityId::FromPacked(*after), count);
  v1::ListEntitiesResponse response;
  size_t bytes = 0;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (i == count || bytes >= kPageBytesMax) {
      response.set_next_page_token(EncodePageToken(ToText({kEntities, epoch_, ids[i - 1].packed()})));
      break;
    }
    v1::Entity* const entity = response.add_entities();
    EncodeEntity(ids[i], *world_->Describe(ids[i]), entity);
    bytes += entity->ByteSizeLong();
  }
  stamp().Encode(response.mutable_stamp());
  response.set_last_sequence(events_->last_sequence());
  return response;
}

Result<v1::ListJointsResponse> HostedWorld::ListJoints(const v1::ListJointsRequest& request) {
  const Result<uint64_t> after = PlaceIn(kJoints, request.page_token());
  if (!after.ok()) return after.status();
  const size_t count = PageSize(request.page_size());
  const std::vector<JointId> ids = IdsAfter(world_->scene(), JointId::FromPacked(*after), count);
  v1::ListJointsResponse response;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (i == count) {
      response.set_next_page_token(EncodePageToken(ToText({kJoints, epoch_, ids[i - 1].packed()})));
      break;
    }
    EncodeJoint(ids[i], world_->scene().joints[ids[i].index()]->desc, response.add_joints());
    EncodeJointState(ids[i], world_->joint_state(ids[i]), response.add_states());
  }
  stamp().Encode(response.mutable_stamp());
  response.set_last_sequence(events_->last_sequence());
  return response;
}

Result<v1::ListForceFieldsResponse> HostedWorld::ListForceFields(const v1::ListForceFieldsRequest& request) {
  const Result<uint64_t> after = PlaceIn(kForceFields, request.page_token());
  if (!after.ok()) return after.status();
  const std::map<ForceFieldId, ForceField>& fields = world_->scene().force_fields;
  const auto count = static_cast<int>(PageSize(request.page_size()));
  v1::ListForceFieldsResponse response;
  size_t bytes = 0;
  for (auto field = fields.upper_bound(*after); field != fields.end(); ++field) {
    if (response.fields_size() == count || bytes >= kPageBytesMax) {
      response.set_next_page_token(EncodePageToken(ToText({kForceFields, epoch_, response.fields().rbegin()->id()})));
      break;
    }
    v1::ForceField* const message = response.add_fields();
    EncodeForceField(field->first, field->second, message);
    bytes += message->ByteSizeLong();
  }
  stamp().Encode(response.mutable_stamp());
  response.set_last_sequence(events_->last_sequence());
  return response;
}

Result<v1::GetWorldResponse> HostedWorld::GetWorld(const v1::GetWorldRequest&) {
  UpdateSummary();
  return summary_.Tell();
}

Result<v1::ResetWorldResponse> HostedWorld::ResetWorld(const v1::ResetWorldRequest&) {
  world_->Reset();
  keyframes_.Clear();
  Stop();
  // Without a first step there is no beginning to come back to, and what broke is still broken.
  if (std::exchange(has_beginning_, false)) broken_ = false;
  epoch_ = NewEpoch();
  state_hash_.reset();
  UpdateSummary();
  events_->Restart(stamp());
  if (frames_->HasViewers()) frames_->Publish(*world_, stamp(), keyframes_);
  if (faulted()) {
    return Refuse(Reason::kDiverged, "", "it failed again, or had no beginning to go back to: the world stays faulted");
  }
  v1::ResetWorldResponse response;
  stamp().Encode(response.mutable_stamp());
  return response;
}

Result<v1::PlayWorldResponse> HostedWorld::PlayWorld(const v1::PlayWorldRequest& request) {
  GENPHYS_RETURN_IF_ERROR(CheckUsable());
  const double factor = request.has_real_time_factor() ? request.real_time_factor() : 1;
  pace_.emplace(factor, world_->layer_state().simulation_time, Pace::Clock::now());
  rests_at_.reset();
  UpdateSummary();
  v1::PlayWorldResponse response;
  stamp().Encode(response.mutable_stamp());
  return response;
}

Result<v1::PauseWorldResponse> HostedWorld::PauseWorld(const v1::PauseWorldRequest&) {
  GENPHYS_RETURN_IF_ERROR(CheckUsable());
  if (pace_ && pace_->overruns() > 0) {
    spdlog::info("{} paused; {} of its steps began late", name_, pace_->overruns());
  }
  Stop();
  v1::PauseWorldResponse response;
  stamp().Encode(response.mutable_stamp());
  return response;
}

void HostedWorld::Break(const Status& why) {
  broken_ = true;
  summary_.SetState(state());
  keyframes_.Clear();
  spdlog::error("{} is faulted: {}", name_, MessageOf(why));
}

void HostedWorld::CatchUp() {
  if (!rests_at_ || !pace_ || faulted()) return;
  const double step_size = world_->scene().world.stepper.step_size;
  const Pace::Clock::time_point now = Pace::Clock::now();
  const uint64_t step = world_->layer_state().step;
  if (world_->IsAtRest()) {
    world_->StepAtRest(pace_->StepsDue(world_->layer_state().simulation_time, step_size, now));
  }
  while (pace_->Due(world_->layer_state().simulation_time + step_size) <= now && Step(std::nullopt).ok()) {
  }
  if (world_->layer_state().step != step) Publish();
}

bool HostedWorld::EndRest() {
  if (!rests_at_ || (pace_ && *rests_at_ == world_->changes() && !frames_->HasViewers())) return false;
  rests_at_.reset();
  return pace_.has_value();
}

std::optional<Pace::Clock::time_point> HostedWorld::Play(Pace::Clock::time_point slice_end) {
  CatchUp();
  rests_at_.reset();
  bool is_quiet = false;
  while (pace_ && !faulted()) {
    const double step_size = world_->scene().world.stepper.step_size;
    const Pace::Clock::time_point now = Pace::Clock::now();
    const Pace::Clock::time_point due = pace_->Due(world_->layer_state().simulation_time + step_size);
    if (due > now) {
      if (!is_quiet || frames_->HasViewers()) return due;
      rests_at_ = world_->changes();
      UpdateSummary();
      return due + pace_->RestFor(step_size);
    }
    pace_->Begin(due, step_size, now);
    const uint64_t changes = world_->changes();
    const Status status = Step(std::nullopt);
    is_quiet = Publish() == nullptr && world_->changes() == changes && pace_->is_timed();
    if (!status.ok()) {
      if (!absl::IsCancelled(status)) spdlog::error("{} stopped playing: {}", name_, MessageOf(status));
      Stop();
      return std::nullopt;
    }
    if (Pace::Clock::now() >= slice_end) return Pace::Clock::now();
  }
  return std::nullopt;
}

}  // namespace genphys

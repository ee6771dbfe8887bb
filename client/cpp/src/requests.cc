#include "requests.h"

#include <string>
#include <utility>

#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"

namespace genphys::client {
namespace {

Stats DecodeStats(const v1::StepStats& stats) {
  Stats decoded{.entities_asleep = stats.entities_asleep(),
                .entities_in_flight = stats.entities_in_flight(),
                .entities_in_engine = stats.entities_in_engine(),
                .pairs = stats.pairs_tested(),
                .contacts = stats.contacts(),
                .islands = stats.islands()};
  for (const v1::StageTime& stage : stats.stages()) decoded.stages.push_back({stage.stage(), stage.nanoseconds()});
  return decoded;
}

}  // namespace

void EncodeFrameOptions(const FrameOptions& options, v1::FrameRequest* out) {
  out->set_scalar(v1::SCALAR_FLOAT64);
  out->set_poses(options.poses);
  out->set_velocities(options.velocities);
  out->set_net_forces(options.net_forces);
  out->set_joints(options.joints);
  out->set_deltas(options.deltas);
  for (const EntityId id : options.entities) out->add_entity_ids(id.packed());
}

void EncodeEventOptions(const EventOptions& options, v1::EventFilter* out) {
  if (options.kinds) EncodeKinds(*options.kinds, out->mutable_kinds());
  for (const EntityId id : options.entities) out->add_entity_ids(id.packed());
}

void EncodeStep(uint32_t steps, const StepOptions& options, v1::StepRequest* out) {
  out->set_steps(steps);
  out->mutable_commands()->Reserve(static_cast<int>(options.commands.size()));
  for (const Command& command : options.commands) EncodeCommand(command, out->add_commands());
  if (options.step_size) out->set_step_size_seconds(*options.step_size);
  if (options.frame) EncodeFrameOptions(*options.frame, out->mutable_frame());
  if (options.events) EncodeEventOptions(*options.events, out->mutable_events());
  out->set_stats(options.stats);
  if (options.expected_step) out->set_expected_step(*options.expected_step);
}

Result<std::vector<Event>> DecodeEvents(const v1::EventBatch& batch) {
  std::vector<Event> events;
  events.reserve(static_cast<size_t>(batch.events_size()));
  for (const v1::Event& event : batch.events()) {
    Result<Event> decoded = DecodeEvent(event);
    if (!decoded.ok())
      return absl::InternalError("this client is too old for the server: " + MessageOf(decoded.status()));
    events.push_back(*std::move(decoded));
  }
  return events;
}

Result<StepResult> DecodeStep(std::shared_ptr<const v1::StepResponse> response, const FramePtr& keyframe) {
  StepResult result{.stamp = DecodeStamp(response->stamp()), .last_sequence = response->events().last_sequence()};
  for (const v1::CommandResult& command : response->results()) {
    result.created.push_back(EntityId::FromPacked(command.created_id()));
  }
  Result<std::vector<Event>> events = DecodeEvents(response->events());
  if (!events.ok()) return events.status();
  result.events = *std::move(events);
  if (response->has_events_left_out()) {
    result.events_left_out =
        Gap{response->events_left_out().first_sequence(), response->events_left_out().last_sequence()};
  }
  if (response->has_stats()) result.stats = DecodeStats(response->stats());
  if (!response->has_frame()) return result;
  Result<FramePtr> whole = WholeFrame(FramePtr(response, &response->frame()), keyframe);
  if (!whole.ok()) return whole.status();
  Result<Frame> frame = Frame::Make(*std::move(whole));
  if (!frame.ok()) return frame.status();
  result.frame = *std::move(frame);
  return result;
}

}  // namespace genphys::client

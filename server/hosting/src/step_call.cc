#include "step_call.h"

#include <google/protobuf/arena.h>

#include <algorithm>
#include <string>
#include <utility>

#include "frame_check.h"
#include "genphys/hosting/world_methods.h"
#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "genphys/wire/error.h"
#include "genphys/wire/wire_format.h"
#include "genphys/work_watch.h"

namespace genphys {

std::optional<Result<EncodedMessage>> StepCall::Advance(Clock::time_point slice_end) {
  if (!begun_) {
    begun_ = true;
    if (const Status status = Begin(); !status.ok()) {
      hosted_.ForgetBeginning();
      return status;
    }
  }
  while (steps_done_ < steps_wanted_) {
    if (const Status status = CheckTime(); !status.ok()) {
      hosted_.ForgetBeginning();
      return Failed(status);
    }
    std::optional<double> step_size;
    if (request_->has_step_size_seconds()) step_size = request_->step_size_seconds();
    const auto begin = Clock::now();
    const Status status = hosted_.Step(step_size);
    Collect(hosted_.Publish());
    if (!status.ok()) return Failed(status);
    has_effect_ = true;
    ++steps_done_;
    const auto end = Clock::now();
    last_step_ = end - begin;
    if (steps_done_ < steps_wanted_ && end >= slice_end) return std::nullopt;
  }
  return Finish();
}

// A client that meets its deadline hears nothing of how far the call came, so this is told while there is time for it:
// no step begins that would likely end too late.
Status StepCall::CheckTime() const {
  GENPHYS_RETURN_IF_ERROR(call_.CheckWanted());
  if (steps_done_ == 0 || Clock::now() + last_step_ < call_.deadline - reply_time_) return {};
  return absl::DeadlineExceededError("no other step would end before the deadline");
}

Status StepCall::Begin() {
  GENPHYS_RETURN_IF_ERROR(call_.CheckWanted());
  const auto now = Clock::now();
  if (call_.deadline > now) reply_time_ = std::min<Clock::duration>((call_.deadline - now) / 10, kReplyTimeMax);
  Result<std::vector<Command>> commands = std::vector<Command>();
  GENPHYS_RETURN_IF_ERROR(TakeRequest(commands));
  steps_wanted_ = request_->has_steps() ? request_->steps() : 1;
  if (steps_wanted_ > 0) GENPHYS_RETURN_IF_ERROR(hosted_.CheckSteppable());
  const uint64_t step = hosted_.world().layer_state().step;
  if (request_->has_expected_step() && request_->expected_step() != step) {
    return Refuse(Reason::kStepMismatch, "expected_step", "the world is at step " + std::to_string(step));
  }
  if (request_->has_events()) {
    events_wanted_.emplace(request_->events());
    const uint64_t last = hosted_.events()->last_sequence();
    response_.mutable_events()->set_first_sequence(last + 1);
    response_.mutable_events()->set_last_sequence(last);
  }
  hosted_.world().set_record_stats(request_->stats());
  if (!commands.ok()) return commands.status();
  if (request_->has_frame()) GENPHYS_RETURN_IF_ERROR(CheckFrameEntities(hosted_.world(), request_->frame()));
  if (steps_wanted_ > 0) hosted_.MarkBeginning();
  const Result<std::vector<CreatedId>> created = hosted_.Apply(*commands);
  if (!created.ok()) {
    hosted_.Publish();
    return created.status();
  }
  for (const CreatedId id : *created) response_.add_results()->set_created_id(id.packed());
  if (commands->empty()) return absl::OkStatus();
  has_effect_ = true;
  if (created->size() < commands->size()) {
    Collect(hosted_.Publish());
    return Failed(WorkWatch::Ask(), static_cast<uint32_t>(created->size()));
  }
  // With steps to come, viewers need no frame of the state between.
  Collect(steps_wanted_ == 0 ? hosted_.Publish() : hosted_.PublishEvents());
  return absl::OkStatus();
}

Status StepCall::TakeRequest(Result<std::vector<Command>>& commands) {
  if (call_.has_commands) {
    google::protobuf::Arena arena;  // a thousand commands are one allocation then
    auto& request = *google::protobuf::Arena::CreateMessage<v1::StepRequest>(&arena);
    GENPHYS_RETURN_IF_ERROR(DecodeRequest(call_.request, &request));
    commands = DecodeCommands(request.commands());
    request.clear_commands();
    request_ = std::make_shared<const v1::StepRequest>(request);
  } else {
    Result<std::shared_ptr<const v1::StepRequest>> request = hosted_.step_requests().Decode(call_.request);
    if (!request.ok()) return request.status();
    request_ = *std::move(request);
    commands = DecodeCommands(request_->commands());
  }
  call_.request = {};
  return absl::OkStatus();
}

Status StepCall::Failed(const Status& status, std::optional<uint32_t> commands_done) const {
  EarlyEnd end{steps_done_, hosted_.world().layer_state().step};
  end.commands_done = commands_done;
  for (const v1::CommandResult& command : response_.results()) {
    end.created.push_back(EntityId::FromPacked(command.created_id()));
  }
  const std::string commands = commands_done ? std::to_string(*commands_done) + " of its commands" : "its commands";
  std::string message = MessageOf(status) + "; of this call stay done: " + commands + " and " +
                        std::to_string(end.steps_done) + " of " + std::to_string(steps_wanted_) +
                        " steps, which led to step " + std::to_string(end.step);
  const std::optional<Refusal> refusal = RefusalOf(status);
  return WithEarlyEnd(refusal ? Refuse(refusal->reason, refusal->field, message) : Status(status.code(), message), end);
}

// Encoded at once, so that a call of many steps keeps no more than it will send.
void StepCall::Collect(const std::shared_ptr<const EventChunk>& chunk) {
  if (chunk == nullptr || !events_wanted_) return;
  v1::EventBatch& batch = *response_.mutable_events();
  for (const Event& event : chunk->events()) {
    const bool is_wanted = events_wanted_->Matches(event);
    if (is_wanted && event_bytes_ >= kEventBytesMax) {
      v1::Gap& left_out = *response_.mutable_events_left_out();
      if (left_out.first_sequence() == 0) left_out.set_first_sequence(event.sequence);
      left_out.set_last_sequence(event.sequence);
    }
    if (response_.has_events_left_out()) continue;
    batch.set_last_sequence(event.sequence);
    if (!is_wanted) continue;
    v1::Event* const message = batch.add_events();
    EncodeEvent(event, message, events_wanted_->contact_points());
    event_bytes_ += message->ByteSizeLong();
  }
}

EncodedMessage StepCall::Finish() {
  const Stamp stamp = hosted_.stamp();
  stamp.Encode(response_.mutable_stamp());
  if (request_->stats() && steps_done_ > 0) EncodeStats(hosted_.world().stats(), response_.mutable_stats());
  return request_->has_frame() ? WithFrame() : EncodedMessage{EncodeReply(response_)};
}

EncodedMessage StepCall::WithFrame() const {
  const v1::FrameRequest& wanted = request_->frame();
  EncodedMessage reply =
      hosted_.keyframes().Encode(hosted_.world(), wanted, response_.stamp(), wanted.keyframe_id()).frame;
  std::string head = response_.SerializeAsString();
  AppendFieldHeader(v1::StepResponse::kFrameFieldNumber, SizeOf(reply), head);
  head += reply.front().view;
  reply.front() = MakeBytes(std::move(head));
  return reply;
}

}  // namespace genphys

#include "genphys/hosting/in_process_host.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include "genphys/backend.h"
#include "genphys/hosting/world_methods.h"
#include "genphys/work_watch.h"
#include "hosted_world.h"
#include "step_call.h"

namespace genphys {
namespace {

// Protobuf encodes no more.
constexpr size_t kReplyBytesMax = std::numeric_limits<int32_t>::max();

Status NoMemory() { return Refuse(Reason::kLimitExceeded, "", "there is not enough memory for this request"); }

// Whether what the method does to a world is nothing, also when it fails halfway.
bool ChangesNothing(WorldMethod method) {
  switch (method) {
    case WorldMethod::kGetWorld:
    case WorldMethod::kGetEntity:
    case WorldMethod::kListEntities:
    case WorldMethod::kListJoints:
    case WorldMethod::kListForceFields:
    case WorldMethod::kCastRays:
    case WorldMethod::kCastShape:
    case WorldMethod::kFindOverlaps:
    case WorldMethod::kFindClosest:
    case WorldMethod::kMeasureDistances:
    case WorldMethod::kGetContacts:
      return true;
    default:
      return false;
  }
}

Status WorldIsGone(WorldMethod method) {
  const bool by_name = method <= WorldMethod::kPauseWorld;
  return Refuse(Reason::kWorldNotFound, by_name ? "name" : "world", "the world was deleted");
}

template <typename Request, typename Response>
Result<EncodedMessage> Answer(HostedWorld& hosted, const WorldCall& call,
                              Result<Response> (HostedWorld::*handle)(const Request&)) {
  Request request;
  GENPHYS_RETURN_IF_ERROR(DecodeRequest(call.request, &request));
  const Result<Response> response = (hosted.*handle)(request);
  if (!response.ok()) return response.status();
  if (response->ByteSizeLong() > kReplyBytesMax) {
    return Refuse(Reason::kLimitExceeded, "", "the reply would be larger than 2 GiB: ask for less at once");
  }
  return EncodedMessage{EncodeReply(*response)};
}

Result<EncodedMessage> AnswerAny(HostedWorld& hosted, const WorldCall& call) {
  switch (call.method) {
    case WorldMethod::kGetWorld:
      return Answer(hosted, call, &HostedWorld::GetWorld);
    case WorldMethod::kResetWorld:
      return Answer(hosted, call, &HostedWorld::ResetWorld);
    case WorldMethod::kPlayWorld:
      return Answer(hosted, call, &HostedWorld::PlayWorld);
    case WorldMethod::kPauseWorld:
      return Answer(hosted, call, &HostedWorld::PauseWorld);
    case WorldMethod::kCreateEntity:
      return Answer(hosted, call, &HostedWorld::CreateEntity);
    case WorldMethod::kDeleteEntity:
      return Answer(hosted, call, &HostedWorld::DeleteEntity);
    case WorldMethod::kApplyForce:
      return Answer(hosted, call, &HostedWorld::ApplyForce);
    case WorldMethod::kGetEntity:
      return Answer(hosted, call, &HostedWorld::GetEntity);
    case WorldMethod::kListEntities:
      return Answer(hosted, call, &HostedWorld::ListEntities);
    case WorldMethod::kListJoints:
      return Answer(hosted, call, &HostedWorld::ListJoints);
    case WorldMethod::kListForceFields:
      return Answer(hosted, call, &HostedWorld::ListForceFields);
    case WorldMethod::kCastRays:
      return Answer(hosted, call, &HostedWorld::CastRays);
    case WorldMethod::kCastShape:
      return Answer(hosted, call, &HostedWorld::CastShape);
    case WorldMethod::kFindOverlaps:
      return Answer(hosted, call, &HostedWorld::FindOverlaps);
    case WorldMethod::kFindClosest:
      return Answer(hosted, call, &HostedWorld::FindClosest);
    case WorldMethod::kMeasureDistances:
      return Answer(hosted, call, &HostedWorld::MeasureDistances);
    case WorldMethod::kGetContacts:
      return Answer(hosted, call, &HostedWorld::GetContacts);
    case WorldMethod::kDeleteWorld:
    case WorldMethod::kStep:
    case WorldMethod::kWatchEvents:
    case WorldMethod::kWatchFrames:
      break;
  }
  return absl::InternalError("no handler for this method");
}

Result<EncodedMessage> AnswerShort(HostedWorld& hosted, const WorldCall& call) {
  if (!ChangesNothing(call.method)) return AnswerAny(hosted, call);
  try {
    return AnswerAny(hosted, call);
  } catch (const std::bad_alloc&) {
    return NoMemory();
  }
}

}  // namespace

// A call in the mailbox.
struct InProcessHost::Pending {
  Pending(WorldCall given_call, Reply given_reply)
      : call(std::move(given_call)), reply(std::move(given_reply)), bytes(call.request.view.size()) {}

  WorldCall call;
  Reply reply;
  const size_t bytes;
  bool is_counted = true;
  uint64_t fingerprint = 0;
  std::optional<StepCall> step;  // set: under way
};

InProcessHost::InProcessHost(WorkerPool& pool) : pool_(pool), strand_(std::make_shared<Strand>(pool)) {}

InProcessHost::~InProcessHost() = default;

Result<std::shared_ptr<WorldHost>> InProcessHost::Create(const BackendRegistry& registry, WorkerPool& pool,
                                                         const std::string& name, const v1::World& wanted,
                                                         std::string_view default_engine) {
  std::shared_ptr<InProcessHost> host(new InProcessHost(pool));
  const auto call_current = [weak = host->weak_from_this()] {
    if (const auto self = weak.lock()) self->strand_->PostUrgent([self] { self->PublishCurrent(); });
  };
  try {
    auto hosted = HostedWorld::Create(registry, pool, name, wanted, default_engine, call_current);
    if (!hosted.ok()) return hosted.status();
    host->hosted_ = *std::move(hosted);
  } catch (const std::exception& exception) {
    return absl::InternalError(std::string("the world cannot be made: ") + exception.what());
  }
  return host;
}

void InProcessHost::Handle(WorldCall call, Reply reply) {
  if (call.method == WorldMethod::kDeleteWorld) {
    if (closing_.exchange(true)) return reply(WorldIsGone(call.method));
    return strand_->PostUrgent([self = shared_from_this(), reply = std::move(reply)] { self->Close(reply); });
  }
  if (call.method == WorldMethod::kGetWorld && !closing_ && hosted_->summary().IsCurrent()) return Tell(call, reply);
  const size_t bytes = call.request.view.size();
  const size_t calls_before = waiting_calls_.fetch_add(1);
  const size_t bytes_before = waiting_bytes_.fetch_add(bytes);
  auto pending = std::make_shared<Pending>(std::move(call), std::move(reply));
  if (calls_before >= kMailboxCallsMax || bytes_before + bytes > kMailboxBytesMax) {
    return Finish(*pending, Refuse(Reason::kLimitExceeded, "", "too many requests wait for this world"));
  }
  if (pending->call.method == WorldMethod::kGetWorld) {
    return strand_->PostUrgent([self = shared_from_this(), pending] { self->Serve(*pending); });
  }
  const bool is_quick = pending->call.method == WorldMethod::kStep && !pending->call.has_commands &&
                        last_step_.load() < pending->call.here_below;
  auto serve = [self = shared_from_this(), pending] { return self->Serve(*pending); };
  if (is_quick) {
    strand_->RunOrPost(std::move(serve));
  } else {
    strand_->Post(std::move(serve));
  }
}

// Here and now, for the world may be in the middle of a long step, and all workers in those of others.
void InProcessHost::Tell(const WorldCall& call, const Reply& reply) const {
  try {
    const Status status = CheckRequest(call.method, call.request);
    reply(status.ok() ? Result<EncodedMessage>(EncodedMessage{EncodeReply(hosted_->summary().Tell())}) : status);
  } catch (const std::bad_alloc&) {
    reply(NoMemory());
  } catch (const std::exception& exception) {
    reply(absl::InternalError(std::string("the request failed: ") + exception.what()));
  }
}

size_t InProcessHost::frame_bytes_max() const { return hosted_->summary().frame_bytes_max(); }

std::shared_ptr<Subscription> InProcessHost::Watch(WorldMethod method, Bytes request) {
  if (method == WorldMethod::kWatchFrames) return hosted_->frames()->Watch(std::move(request));
  return hosted_->events()->Watch(std::move(request));
}

void InProcessHost::Drain(Status why) {
  draining_ = true;
  strand_->PostUrgent([self = shared_from_this(), why] {
    self->hosted_->Stop();
    self->hosted_->events()->End(why);
    self->hosted_->frames()->End(why);
  });
}

void InProcessHost::Finish(Pending& pending, const Result<EncodedMessage>& outcome) {
  // A reply that could not be sent for want of memory comes here again, as an error.
  if (std::exchange(pending.is_counted, false)) {
    waiting_calls_.fetch_sub(1);
    waiting_bytes_.fetch_sub(pending.bytes);
  }
  pending.call.request = {};
  pending.reply(outcome);
}

Progress InProcessHost::Serve(Pending& pending) {
  const WorkWatch watch([&] { return closing_ ? WorldIsGone(pending.call.method) : pending.call.CheckWanted(); });
  try {
    if (closing_) {
      Finish(pending, WorldIsGone(pending.call.method));
      return Progress::kDone;
    }
    if (!pending.step) {
      if (const std::optional<Result<EncodedMessage>> repeated = FindReply(pending)) {
        Finish(pending, *repeated);
        return Progress::kDone;
      }
    }
    hosted_->CatchUp();
    return pending.call.method == WorldMethod::kStep ? ServeStep(pending) : ServeShort(pending);
  } catch (const CutShort& cut) {
    // Thrown by what has changed nothing yet.
    FinishAndKeep(pending, cut.why(), false);
  } catch (const std::bad_alloc&) {
    Finish(pending, Broken(NoMemory()));
  } catch (const EngineFault& fault) {
    Finish(pending, Broken(Refuse(Reason::kDiverged, "", std::string("the engine failed: ") + fault.what())));
  } catch (const std::exception& exception) {
    Finish(pending, Broken(absl::InternalError(std::string("the request failed: ") + exception.what())));
  } catch (...) {
    // Nothing may leave: this can be a thread of gRPC's, which would end the program.
    Finish(pending, Broken(absl::InternalError("the request failed with an exception of an unknown type")));
  }
  return Progress::kDone;
}

std::optional<Result<EncodedMessage>> InProcessHost::FindReply(Pending& pending) {
  const WorldCall& call = pending.call;
  if (call.request_id.empty()) return std::nullopt;
  pending.fingerprint = ReplyCache::Fingerprint(InfoOf(call.method).name, call.request.view);
  return replies_.Find(call.request_id, pending.fingerprint);
}

// The caller does not wait for its reply to be kept: a retry comes to this strand too, and so after that.
void InProcessHost::FinishAndKeep(Pending& pending, const Result<EncodedMessage>& outcome, bool keep) {
  if (hosted_->EndRest()) PostPlay(++play_generation_);
  Finish(pending, outcome);
  if (!keep || pending.call.request_id.empty()) return;
  try {
    replies_.Keep(pending.call.request_id, pending.fingerprint, outcome);
  } catch (const std::bad_alloc&) {
    // It was answered, which is not to be taken back; as after many other requests, a retry is done again.
  }
}

Progress InProcessHost::ServeShort(Pending& pending) {
  const Status wanted = pending.call.CheckWanted();
  const Result<EncodedMessage> outcome = wanted.ok() ? AnswerShort(*hosted_, pending.call) : wanted;
  if (outcome.ok() && pending.call.method == WorldMethod::kPlayWorld) PostPlay(++play_generation_);
  FinishAndKeep(pending, outcome, outcome.ok());
  return Progress::kDone;
}

Progress InProcessHost::ServeStep(Pending& pending) {
  if (!pending.step) pending.step.emplace(*hosted_, pending.call);
  const auto begin = std::chrono::steady_clock::now();
  const uint32_t steps_before = pending.step->steps_done();
  const std::optional<Result<EncodedMessage>> outcome = pending.step->Advance(begin + kSlice);
  const uint32_t steps = std::max(pending.step->steps_done() - steps_before, 1u);
  last_step_ = (std::chrono::steady_clock::now() - begin) / steps;
  if (!outcome) return Progress::kAgain;
  // A call that stopped half way must not be done again by a retry either.
  FinishAndKeep(pending, *outcome, outcome->ok() || pending.step->has_effect());
  return Progress::kDone;
}

Status InProcessHost::Broken(const Status& why) {
  hosted_->Break(why);
  return why;
}

void InProcessHost::PostPlay(uint64_t generation) {
  strand_->Post([self = shared_from_this(), generation] {
    self->Play(generation);
    return Progress::kDone;
  });
}

void InProcessHost::Play(uint64_t generation) {
  if (closing_ || generation != play_generation_) return;
  const WorkWatch watch([&] {
    return closing_ || draining_ ? absl::CancelledError("the world does not play any more") : absl::OkStatus();
  });
  try {
    const auto now = std::chrono::steady_clock::now();
    const auto next = hosted_->Play(now + kSlice);
    if (!next) return;
    if (*next <= std::chrono::steady_clock::now()) return PostPlay(generation);
    pool_.PostAt(*next, [weak = weak_from_this(), generation] {
      if (const auto self = weak.lock()) self->PostPlay(generation);
    });
  } catch (const std::exception& exception) {
    Broken(absl::InternalError(std::string("a step failed: ") + exception.what())).IgnoreError();
    hosted_->Stop();
  }
}

void InProcessHost::PublishCurrent() {
  try {
    hosted_->CatchUp();
    hosted_->frames()->PublishCurrent(hosted_->world(), hosted_->stamp(), hosted_->keyframes());
    if (hosted_->EndRest()) PostPlay(++play_generation_);
  } catch (const std::exception& exception) {
    spdlog::error("no frame can be made: {}", exception.what());
  }
}

void InProcessHost::Close(const Reply& reply) {
  v1::DeleteWorldResponse response;
  hosted_->CatchUp();
  hosted_->stamp().Encode(response.mutable_stamp());
  hosted_->Stop();
  hosted_->events()->End(absl::OkStatus());
  hosted_->frames()->End(absl::OkStatus());
  reply(EncodedMessage{EncodeReply(response)});
}

}  // namespace genphys

#include "connection.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <cstdio>
#include <random>
#include <thread>

#include "genphys/wire/error.h"

namespace genphys::client {
namespace {

// Streams have no deadline, so an unanswered ping is how they notice that the server's machine is gone. The server
// permits pings this often.
constexpr int kKeepaliveMilliseconds = 60'000;
constexpr int kKeepaliveTimeoutMilliseconds = 10'000;
// A stream comes back as soon as its server does; gRPC's own pause grows to two minutes.
constexpr int kReconnectMillisecondsMin = 100;
constexpr int kReconnectMillisecondsMax = 1'000;

// Between attempts of one call; doubled each time, and shortened at random so that clients do not come back all at
// once.
constexpr std::chrono::milliseconds kPauseFirst{100};
constexpr int kAttemptsMax = 4;

constexpr char kStepMethod[] = "/genphys.v1.SimulationService/Step";

std::shared_ptr<grpc::Channel> MakeChannel(const std::string& address) {
  grpc::ChannelArguments arguments;
  // A frame of 50,000 entities is larger than the 4 MiB that gRPC allows unless told.
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetMaxSendMessageSize(-1);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMilliseconds);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMilliseconds);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kReconnectMillisecondsMin);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, kReconnectMillisecondsMin);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kReconnectMillisecondsMax);
  // Calls are retried here (Retry); the filter that could do it costs a microsecond of each.
  arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  // The address is meant as it stands, whatever proxy the environment names for the web.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

std::string RandomPrefix() {
  std::random_device random;
  char text[32];
  std::snprintf(text, sizeof text, "%08x%08x%08x-", random(), random(), random());
  return text;
}

}  // namespace

Status FromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  google::rpc::Status details;
  if (!status.error_details().empty() && details.ParseFromString(status.error_details())) return DecodeStatus(details);
  return Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
}

Connection::Connection(const std::string& address, const ConnectOptions& options)
    : address_(address),
      deadline_(options.deadline),
      channel_(MakeChannel(address)),
      engines_(channel_),
      worlds_(channel_),
      simulation_(channel_),
      step_(channel_),
      request_prefix_(RandomPrefix()) {}

bool IsGone(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::UNAVAILABLE || status.error_code() == grpc::StatusCode::CANCELLED;
}

bool Retry::Again(const grpc::Status& status) {
  if (!IsGone(status) || attempts_ == kAttemptsMax) return false;
  static thread_local std::minstd_rand random{std::random_device{}()};
  const auto pause = std::uniform_real_distribution(0.5, 1.0)(random) * (1 << (attempts_ - 1)) *
                     std::chrono::duration<double, std::milli>(kPauseFirst);
  const auto next = std::chrono::system_clock::now() + std::chrono::round<std::chrono::system_clock::duration>(pause);
  if (next >= deadline_) return false;
  std::this_thread::sleep_until(next);
  ++attempts_;
  return true;
}

Status Connection::WaitUntilConnected(std::chrono::milliseconds timeout) {
  if (channel_->WaitForConnected(std::chrono::system_clock::now() + timeout)) return absl::OkStatus();
  return absl::UnavailableError("no server answers at " + address_ + "; script/server starts one");
}

Result<std::shared_ptr<const v1::StepResponse>> Connection::Step(const v1::StepRequest& request, Deadline deadline) {
  const std::shared_ptr<StepReply> reply = step_replies_->Take();
  // Empty between calls. To make one for each costs more than a microsecond.
  static thread_local grpc::CompletionQueue queue;
  GENPHYS_RETURN_IF_ERROR(CallAgain(deadline, [&](grpc::ClientContext* context) {
    const auto call = step_.PrepareUnaryCall(context, kStepMethod, request, &queue);
    call->StartCall();
    grpc::Status status;
    call->Finish(reply.get(), &status, nullptr);
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    return status;
  }));
  return std::shared_ptr<const v1::StepResponse>(reply, &reply->message());
}

std::string Connection::NextRequestId() { return request_prefix_ + std::to_string(++requests_); }

}  // namespace genphys::client

#pragma once
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "genphys/client/options.h"
#include "genphys/status.h"
#include "genphys/v1/engine_service.grpc.pb.h"
#include "genphys/v1/simulation_service.grpc.pb.h"
#include "genphys/v1/world_service.grpc.pb.h"
#include "step_replies.h"

namespace genphys::client {

/// The status of a call, with the refusal that the server sent restored.
Status FromGrpc(const grpc::Status& status);

/// Whether a call failed because the server was not there, or went. Of calls that nobody cancelled: what comes in the
/// last moments of a server that shuts down ends as cancelled.
bool IsGone(const grpc::Status& status);

/// Whether a call is made once more: gRPC can do the same, for 5 us of every call that needs no second attempt.
class Retry {
 public:
  explicit Retry(std::chrono::system_clock::time_point deadline) : deadline_(deadline) {}

  /// True after a pause, if the server was not there, the deadline is not met and not too many attempts were made.
  bool Again(const grpc::Status& status);

 private:
  std::chrono::system_clock::time_point deadline_;
  int attempts_ = 1;
};

/// A channel to one server and the stubs on it. Thread-safe.
class Connection {
 public:
  using Deadline = std::optional<std::chrono::milliseconds>;

  Connection(const std::string& address, const ConnectOptions& options);

  Status WaitUntilConnected(std::chrono::milliseconds timeout);

  v1::EngineService::Stub& engines() { return engines_; }
  v1::WorldService::Stub& worlds() { return worlds_; }
  v1::SimulationService::Stub& simulation() { return simulation_; }
  std::chrono::milliseconds deadline() const { return deadline_; }

  /// One call that is no stream; without a deadline of its own it has the connection's. It is repeated while the server
  /// is not there, so it reads, or carries a request id by which it is done once.
  template <typename Stub, typename Request, typename Response>
  Status Call(Stub& stub, grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
              const Request& request, Response* response, Deadline deadline = std::nullopt) {
    return CallAgain(deadline,
                     [&](grpc::ClientContext* context) { return (stub.*method)(context, request, response); });
  }

  /// Step in the same way. The answer's memory is used again when the last who holds it lets go.
  Result<std::shared_ptr<const v1::StepResponse>> Step(const v1::StepRequest& request,
                                                       Deadline deadline = std::nullopt);

  /// The same for calls that must not be made twice.
  template <typename Stub, typename Request, typename Response>
  Status CallOnce(Stub& stub, grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                  const Request& request, Response* response, Deadline deadline = std::nullopt) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline.value_or(deadline_));
    return FromGrpc((stub.*method)(&context, request, response));
  }

  /// A name for a call that no other call of any client has: the server knows a retry by it.
  std::string NextRequestId();

 private:
  template <typename Attempt>
  Status CallAgain(Deadline deadline, const Attempt& attempt) {
    const auto until = std::chrono::system_clock::now() + deadline.value_or(deadline_);
    Retry retry(until);
    while (true) {
      grpc::ClientContext context;
      context.set_deadline(until);
      const grpc::Status status = attempt(&context);
      if (!retry.Again(status)) return FromGrpc(status);
    }
  }

  std::string address_;
  std::chrono::milliseconds deadline_;
  std::shared_ptr<grpc::Channel> channel_;
  v1::EngineService::Stub engines_;
  v1::WorldService::Stub worlds_;
  v1::SimulationService::Stub simulation_;
  StepStub step_;
  std::shared_ptr<StepReplies> step_replies_ = std::make_shared<StepReplies>();
  std::string request_prefix_;
  std::atomic<uint64_t> requests_{0};
};

}  // namespace genphys::client

#pragma once
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/support/async_stream.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "connection.h"
#include "genphys/client/drive.h"
#include "genphys/v1/simulation_service.pb.h"
#include "keyframes.h"

namespace genphys::client {

/// A stream that its user's thread works by itself: waking another one for each message takes longer than the message.
class Drive::Impl {
 public:
  Impl(std::shared_ptr<Connection> connection, std::string world, std::shared_ptr<Keyframes> keyframes);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Status Send(uint32_t steps, const StepOptions& options);
  Result<StepResult> Receive(std::optional<std::chrono::milliseconds> timeout);
  size_t in_flight() const { return in_flight_.size(); }
  void Cancel() { context_.TryCancel(); }

 private:
  // Each is under way once at a time, so that it is its own tag.
  enum Operation : unsigned { kStart = 1, kWrite = 2, kRead = 4, kFinish = 8 };
  static void* TagOf(Operation operation) { return reinterpret_cast<void*>(uintptr_t{operation}); }

  // What the answer to a request may be a delta against, and which frame it asked for if that may be.
  struct InFlight {
    FramePtr keyframe;
    std::optional<v1::FrameRequest> wishes;
  };

  // False when nothing came until then. Without a limit something must be pending.
  bool WaitForOne(std::optional<std::chrono::system_clock::time_point> until);
  void WriteNext();
  void ReadNext();
  void Finish();
  Status EndOfStream() const;

  const std::shared_ptr<Connection> connection_;
  const std::string world_;
  const std::shared_ptr<Keyframes> keyframes_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::ClientAsyncReaderWriter<v1::DriveRequest, v1::DriveResponse>> call_;
  unsigned pending_ = 0;
  bool started_ = false;
  bool finished_ = false;
  grpc::Status status_;                                    // once finished_
  std::deque<std::unique_ptr<v1::DriveRequest>> waiting_;  // to be written
  std::unique_ptr<v1::DriveRequest> written_;              // belongs to gRPC during a write
  std::shared_ptr<v1::DriveResponse> response_;            // set: it is being read
  bool read_wanted_ = false;
  std::deque<InFlight> in_flight_;
};

}  // namespace genphys::client

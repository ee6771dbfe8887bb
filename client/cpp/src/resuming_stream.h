#pragma once
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "connection.h"
#include "genphys/status.h"
#include "stream_call.h"

namespace genphys::client {

/// How long a stream tries to come back after its connection was lost.
inline constexpr std::chrono::seconds kReconnectFor{30};

/// A server stream that outlives its connection: when that is lost, the request is sent again, as the owner keeps it
/// up to date. One thread reads, any thread cancels.
template <typename Request, typename Inbox>
class ResumingStream {
 public:
  using Response = typename Inbox::Response;
  using Call = StreamCall<Inbox>;
  using TimePoint = typename Call::TimePoint;
  using Async = class v1::SimulationService::Stub::async;  // a member function has the same name
  using Method = void (Async::*)(grpc::ClientContext*, const Request*, grpc::ClientReadReactor<Response>*);

  ResumingStream(std::shared_ptr<Connection> connection, Method method, Request request)
      : connection_(std::move(connection)), method_(method), request_(std::move(request)) {
    Subscribe(/*wait_until_connected=*/false);
  }

  /// What is asked for when the stream has to come back.
  Request& request() { return request_; }

  /// True with what the inbox has in `out`, false at the end. DEADLINE_EXCEEDED at `until`: the stream lives on.
  Result<bool> Next(typename Inbox::Item* out, std::optional<TimePoint> until) {
    for (;;) {
      std::optional<TimePoint> limit = until;
      if (lost_) limit = std::min(until.value_or(TimePoint::max()), *lost_ + kReconnectFor);
      switch (call_->Next(out, limit)) {
        case Call::Outcome::kItem:
          lost_.reset();
          return true;
        case Call::Outcome::kTimeout:
          if (limit == until) return absl::DeadlineExceededError("nothing came in time");
          return absl::UnavailableError("the connection was lost and did not come back");
        case Call::Outcome::kEnd:
          const Status status = FromGrpc(call_->status());
          if (status.ok() || cancelled()) return false;
          if (!IsGone(call_->status())) return status;
          if (!ComeBack()) return cancelled() ? Result<bool>(false) : Result<bool>(status);
      }
    }
  }

  void Cancel() {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    call_->Cancel();
    changed_.notify_all();
  }

 private:
  bool cancelled() {
    const std::lock_guard lock(mutex_);
    return cancelled_;
  }

  void Subscribe(bool wait_until_connected) {
    // Made before the lock, for the end of the old call may have to be waited for.
    auto call = std::make_unique<Call>(
        [this](grpc::ClientContext* context, Call* reactor) {
          (connection_->simulation().async()->*method_)(context, &request_, reactor);
        },
        wait_until_connected);
    const std::lock_guard lock(mutex_);
    std::swap(call_, call);
    if (cancelled_) call_->Cancel();
  }

  /// False when it was cancelled or has tried for long enough.
  bool ComeBack() {
    // A server that is shutting down answers at once; asking again at once would only keep it busy.
    constexpr std::chrono::milliseconds kPause{100};
    const TimePoint now = std::chrono::steady_clock::now();
    if (!lost_) lost_ = now;
    if (now >= *lost_ + kReconnectFor) return false;
    {
      std::unique_lock lock(mutex_);
      if (changed_.wait_for(lock, kPause, [this] { return cancelled_; })) return false;
    }
    Subscribe(/*wait_until_connected=*/true);
    return true;
  }

  std::shared_ptr<Connection> connection_;
  Method method_;
  Request request_;  // read by gRPC only while a call starts
  std::optional<TimePoint> lost_;
  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::unique_ptr<Call> call_;
  bool cancelled_ = false;
};

}  // namespace genphys::client

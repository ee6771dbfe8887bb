#pragma once
#include <grpcpp/support/client_callback.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>

namespace genphys::client {

/// One server stream, read by one thread at its own pace: the next message is asked for when the last one is taken, so
/// that gRPC's flow control, and not a queue of ours, holds a fast server back. Any thread may cancel.
template <typename Response>
class StreamCall final : public grpc::ClientReadReactor<Response> {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  enum class Outcome { kMessage, kEnd, kTimeout };

  /// `start(context, reactor)` starts the call on a stub.
  template <typename Start>
  StreamCall(const Start& start, bool wait_until_connected) {
    context_.set_wait_for_ready(wait_until_connected);
    start(&context_, this);
    // Reads are started from outside of reactions: the hold keeps the call from being done between two of them.
    this->AddHold();
    this->StartRead(&response_);
    this->StartCall();
  }

  ~StreamCall() override {
    context_.TryCancel();
    std::unique_lock lock(mutex_);
    closing_ = true;
    if (ready_) {
      ready_ = false;
      lock.unlock();
      this->RemoveHold();
      lock.lock();
    }
    changed_.wait(lock, [this] { return done_; });
  }

  /// Waits for a message, the end, or `until`.
  Outcome Next(Response* out, std::optional<TimePoint> until) {
    std::unique_lock lock(mutex_);
    const auto has_news = [this] { return ready_ || done_; };
    if (!until) {
      changed_.wait(lock, has_news);
    } else if (!changed_.wait_until(lock, *until, has_news)) {
      return Outcome::kTimeout;
    }
    if (!ready_) return Outcome::kEnd;
    out->Swap(&response_);
    ready_ = false;
    lock.unlock();
    this->StartRead(&response_);
    return Outcome::kMessage;
  }

  void Cancel() { context_.TryCancel(); }

  /// Only after Next() said kEnd.
  const grpc::Status& status() const { return status_; }

  void OnReadDone(bool ok) override {
    std::unique_lock lock(mutex_);
    if (ok && !closing_) {
      ready_ = true;
      changed_.notify_all();
      return;
    }
    lock.unlock();
    this->RemoveHold();
  }

  void OnDone(const grpc::Status& status) override {
    // Told under the lock: whoever waits may destroy this as soon as it is let go.
    const std::lock_guard lock(mutex_);
    status_ = status;
    done_ = true;
    changed_.notify_all();
  }

 private:
  grpc::ClientContext context_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Response response_;   // belongs to gRPC while a read is under way
  bool ready_ = false;  // response_ is a message that nobody took; no read is under way
  bool done_ = false;
  bool closing_ = false;  // nobody will take another message
  grpc::Status status_;
};

}  // namespace genphys::client

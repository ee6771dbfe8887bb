#pragma once
#include <grpcpp/support/client_callback.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace genphys::client {

/// Every message in order: the next one is asked for when the last one is taken, so that gRPC's flow control, and not a
/// queue of ours, holds a fast server back.
template <typename Message>
class EachMessage {
 public:
  using Response = Message;
  using Item = Message;
  static constexpr bool kReadsOn = false;

  void Put(Response* received) { message_.Swap(received); }
  void Take(Item* out) { out->Swap(&message_); }

 private:
  Response message_;
};

/// One server stream, whose items one thread takes at its own pace; any thread may cancel. `Inbox` is what lies between
/// gRPC's threads and that one, here with a lock held: what it makes of messages that come while nobody takes them, and
/// whether they are read before that at all.
template <typename Inbox>
class StreamCall final : public grpc::ClientReadReactor<typename Inbox::Response> {
 public:
  using Item = typename Inbox::Item;
  using TimePoint = std::chrono::steady_clock::time_point;
  enum class Outcome { kItem, kEnd, kTimeout };

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
    if (idle_) {
      idle_ = false;
      lock.unlock();
      this->RemoveHold();
      lock.lock();
    }
    changed_.wait(lock, [this] { return done_; });
  }

  /// Waits for an item, the end, or `until`.
  Outcome Next(Item* out, std::optional<TimePoint> until) {
    std::unique_lock lock(mutex_);
    const auto has_news = [this] { return ready_ || done_; };
    if (!until) {
      changed_.wait(lock, has_news);
    } else if (!changed_.wait_until(lock, *until, has_news)) {
      return Outcome::kTimeout;
    }
    if (!ready_) return Outcome::kEnd;
    inbox_.Take(out);
    ready_ = false;
    if (!std::exchange(idle_, false)) return Outcome::kItem;
    lock.unlock();
    this->StartRead(&response_);
    return Outcome::kItem;
  }

  void Cancel() { context_.TryCancel(); }

  /// Only after Next() said kEnd.
  const grpc::Status& status() const { return status_; }

  void OnReadDone(bool ok) override {
    std::unique_lock lock(mutex_);
    if (ok && !closing_) {
      inbox_.Put(&response_);
      ready_ = true;
      idle_ = !Inbox::kReadsOn;
      changed_.notify_all();
      if (idle_) return;
      lock.unlock();
      this->StartRead(&response_);
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
  typename Inbox::Response response_;  // belongs to gRPC while a read is under way
  Inbox inbox_;
  bool ready_ = false;  // there is something in the inbox
  bool idle_ = false;   // no read is under way, but the stream has not ended
  bool done_ = false;
  bool closing_ = false;  // nobody will take another message
  grpc::Status status_;
};

}  // namespace genphys::client

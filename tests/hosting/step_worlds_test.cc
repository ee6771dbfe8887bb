// Which replies of StepWorlds come together, how long the first waits for the others, and how many wait for a client.
#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "genphys/hosting/step_worlds_call.h"
#include "genphys/v1/simulation_service.pb.h"

namespace genphys {
namespace {

// Longer than any reply may be kept.
constexpr std::chrono::seconds kLong{20};

// A call to worlds that answer when they are told to.
class Call {
 public:
  explicit Call(size_t worlds, size_t expected_bytes = 0) {
    call_ = std::make_shared<StepWorldsCall>(
        std::vector<Bytes>(worlds), deadline_, pool_,
        [this](const WorldCall& call, Reply reply) {
          const std::lock_guard lock(mutex_);
          EXPECT_LT(call.deadline, deadline_);
          replies_.push_back(std::move(reply));
        },
        [=](const Bytes&) { return expected_bytes; });
    call_->Begin();
  }
  ~Call() {
    call_->Cancel();
    Answer(begun() - answered_);
  }

  // The next `count` worlds answer, each with so many bytes. A world that begins meanwhile is one of them.
  void Answer(size_t count, size_t bytes = 0) {
    for (; count > 0; --count) AnswerOne(answered_++, bytes);
  }
  void AnswerOne(size_t world, size_t bytes = 0) {
    Reply reply;
    {
      const std::lock_guard lock(mutex_);
      reply = std::exchange(replies_[world], nullptr);
    }
    if (reply) reply(EncodedMessage{MakeBytes(std::string(bytes, 'x'))});
  }
  // All answer that have begun, and those that begin by that.
  void AnswerAll(size_t bytes) {
    while (answered_ < begun()) Answer(1, bytes);
  }
  size_t begun() const {
    const std::lock_guard lock(mutex_);
    return replies_.size();
  }
  // Whether so many begin, sooner or later.
  bool Begins(size_t count) const {
    const auto give_up = WorkerPool::Clock::now() + kLong;
    while (begun() < count && WorkerPool::Clock::now() < give_up) std::this_thread::yield();
    return begun() >= count;
  }

  // How many replies the next message has; it is asked for now.
  std::future<int> Next() {
    auto promise = std::make_shared<std::promise<int>>();
    call_->Next([promise](const Delivery& delivery) {
      v1::StepWorldsResponse message;
      if (delivery.message) message.ParseFromString(Joined(*delivery.message));
      promise->set_value(message.results_size());
    });
    return promise->get_future();
  }

 private:
  WorkerPool pool_{1};
  const WorkerPool::Clock::time_point deadline_ = WorkerPool::Clock::now() + 2 * kLong;
  mutable std::mutex mutex_;
  std::deque<Reply> replies_;
  size_t answered_ = 0;
  std::shared_ptr<StepWorldsCall> call_;
};

TEST(StepWorldsCall, TellsOneReplyThoughTheOthersTakeLong) {
  Call call(3);
  std::future<int> first = call.Next();
  call.Answer(1);
  ASSERT_EQ(first.wait_for(kLong), std::future_status::ready);
  EXPECT_EQ(first.get(), 1);
}

TEST(StepWorldsCall, TellsTogetherWhatComesTogether) {
  constexpr size_t kWorlds = StepWorldsCall::kGathered + 3;
  Call call(kWorlds);
  std::future<int> first = call.Next();
  call.Answer(StepWorldsCall::kGathered);
  ASSERT_EQ(first.wait_for(kLong), std::future_status::ready);
  // A machine that stands still for a while makes two messages of them, never one of each.
  EXPECT_GE(first.get(), 2);
}

TEST(StepWorldsCall, DoesNotWaitOnceAllHaveAnswered) {
  Call call(3);
  call.Answer(3);
  // At once, on this thread.
  EXPECT_EQ(call.Next().wait_for(std::chrono::seconds(0)), std::future_status::ready);
}

// More than a machine that stands still for a while takes for slow: see StepWorldsCall::kLong.
constexpr int kVeryMany = 2000;

TEST(StepWorldsCall, GoesOnWhileItIsReadAndHoldsFewRepliesThatNobodyReads) {
  Call call(kVeryMany);
  call.AnswerAll(10);
  EXPECT_LT(static_cast<int>(call.begun()), kVeryMany / 4) << "nobody has asked for any";

  std::future<int> read = call.Next();
  for (size_t begun = 0; begun != call.begun();) {
    begun = call.begun();
    call.AnswerAll(10);
    // One message is with a client that does not come back for the next.
    ASSERT_EQ(read.wait_for(kLong), std::future_status::ready);
  }
  int told = read.get();
  EXPECT_LT(static_cast<int>(call.begun()), told + kVeryMany / 4);

  while (told < kVeryMany) {
    read = call.Next();
    call.AnswerAll(10);
    ASSERT_EQ(read.wait_for(kLong), std::future_status::ready);
    told += read.get();
  }
  EXPECT_EQ(told, kVeryMany);
}

TEST(StepWorldsCall, LetsNobodyWaitForSlowWorlds) {
  Call call(5 * StepWorldsCall::kWithWorldsMax);
  std::future<int> first = call.Next();
  EXPECT_GE(call.begun(), StepWorldsCall::kWithWorldsMax) << "those that go at once";
  ASSERT_TRUE(call.Begins(5 * StepWorldsCall::kWithWorldsMax)) << "none of them has answered";
  call.AnswerOne(5 * StepWorldsCall::kWithWorldsMax - 1);
  ASSERT_EQ(first.wait_for(kLong), std::future_status::ready);
  EXPECT_EQ(first.get(), 1);
  call.Answer(5 * StepWorldsCall::kWithWorldsMax - 1);
}

TEST(StepWorldsCall, WaitsForSlowWorldsWhereRepliesWouldBeTooManyBytes) {
  constexpr size_t kBytes = StepWorldsCall::kUnsentBytesMax / 5;
  Call call(30, kBytes);
  EXPECT_EQ(call.begun(), 5u);
  std::this_thread::sleep_for(5 * StepWorldsCall::kLong);
  EXPECT_EQ(call.begun(), 5u) << "they are to come, however long they take";
  std::future<int> first = call.Next();
  call.Answer(1, 10);
  EXPECT_TRUE(call.Begins(6));
}

TEST(StepWorldsCall, ExpectsRepliesToBeLargerOnceOneWas) {
  constexpr size_t kBytes = StepWorldsCall::kUnsentBytesMax / 5;
  Call call(kVeryMany);
  std::future<int> first = call.Next();
  call.Answer(1, kBytes);
  std::this_thread::sleep_for(5 * StepWorldsCall::kLong);
  const auto begun = static_cast<int>(call.begun());
  EXPECT_LT(begun, kVeryMany) << "some are still to begin";
  std::this_thread::sleep_for(5 * StepWorldsCall::kLong);
  EXPECT_EQ(static_cast<int>(call.begun()), begun);
}

TEST(StepWorldsCall, HoldsFewBytesThatNobodyReads) {
  constexpr size_t kBytes = StepWorldsCall::kMessageBytesMax;
  constexpr int kHeld = StepWorldsCall::kUnsentBytesMax / kBytes;
  Call call(30, kBytes);
  std::future<int> first = call.Next();
  call.AnswerAll(kBytes);
  EXPECT_EQ(first.get(), 1);
  EXPECT_LE(call.begun(), 1 + kHeld);

  for (int told = 1; told < 30; ++told) {
    std::future<int> next = call.Next();
    ASSERT_EQ(next.wait_for(kLong), std::future_status::ready) << told;
    EXPECT_EQ(next.get(), 1);
    call.AnswerAll(kBytes);
    EXPECT_LE(call.begun(), 1u + told + kHeld);
  }
}

TEST(StepWorldsCall, SendsRepliesThatAreLargerThanAllThatMayWait) {
  Call call(3);
  for (int told = 0; told < 3; ++told) {
    std::future<int> next = call.Next();
    ASSERT_LT(static_cast<size_t>(told), call.begun());
    call.Answer(1, StepWorldsCall::kUnsentBytesMax + 1);
    ASSERT_EQ(next.wait_for(kLong), std::future_status::ready);
    EXPECT_EQ(next.get(), 1);
  }
}

}  // namespace
}  // namespace genphys

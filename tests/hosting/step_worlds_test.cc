// Which replies of StepWorlds come together, and how long the first waits for the others.
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
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
  explicit Call(size_t worlds) : worlds_(worlds) {
    call_ = std::make_shared<StepWorldsCall>(
        std::vector<Bytes>(worlds), WorkerPool::Clock::now() + 2 * kLong, pool_,
        [this](const WorldCall&, Reply reply) { replies_.push_back(std::move(reply)); });
    call_->Begin();
  }
  ~Call() {
    call_->Cancel();
    Answer(worlds_ - answered_);
  }

  // The next `count` worlds answer.
  void Answer(size_t count) {
    for (; count > 0; --count) replies_[answered_++](EncodedMessage{});
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
  const size_t worlds_;
  WorkerPool pool_{1};
  std::vector<Reply> replies_;
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

}  // namespace
}  // namespace genphys

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "genphys/hosting/strand.h"
#include "genphys/hosting/worker_pool.h"

namespace genphys {
namespace {

using std::chrono::milliseconds;

constexpr std::chrono::seconds kPatience{60};  // only what hangs meets it

// Waits until all that was posted to `strand` before is done.
void Settle(Strand& strand) {
  std::promise<void> done;
  strand.Post([&] {
    done.set_value();
    return Progress::kDone;
  });
  ASSERT_EQ(done.get_future().wait_for(kPatience), std::future_status::ready);
}

TEST(WorkerPool, RunsEveryTaskOnItsThreads) {
  constexpr int kTasks = 1000;
  std::atomic<int> ran = 0;
  {
    WorkerPool pool(3);
    EXPECT_EQ(pool.threads(), 3u);
    for (int i = 0; i < kTasks; ++i) pool.Post([&] { ++ran; });
  }
  EXPECT_EQ(ran, kTasks);
}

TEST(WorkerPool, RunsTasksWhileOthersHoldAllOfItsThreads) {
  constexpr int kHolders = 5;
  WorkerPool pool(2);
  std::promise<void> end;
  const std::shared_future<void> ended = end.get_future().share();
  for (int i = 0; i < kHolders; ++i) pool.Post([ended] { ended.wait(); });
  for (int i = 0; i < 3; ++i) {
    std::promise<void> ran;
    pool.Post([&] { ran.set_value(); });
    ASSERT_EQ(ran.get_future().wait_for(kPatience), std::future_status::ready);
  }
  end.set_value();
}

TEST(WorkerPool, HasNoMoreThreadsThanItShouldOnceNoneIsHeld) {
  WorkerPool pool(2);
  std::promise<void> end;
  const std::shared_future<void> ended = end.get_future().share();
  for (int i = 0; i < 4; ++i) pool.Post([ended] { ended.wait(); });
  std::promise<void> ran;
  pool.Post([&] { ran.set_value(); });
  ASSERT_EQ(ran.get_future().wait_for(kPatience), std::future_status::ready);
  end.set_value();
  // Shorter than what holds a worker, so that no other spare one comes.
  const auto most_at_once = [&pool] {
    constexpr int kTasks = 40;
    std::atomic<int> now = 0, most = 0, done = 0;
    for (int i = 0; i < kTasks; ++i) {
      pool.Post([&] {
        most = std::max(most.load(), ++now);
        std::this_thread::sleep_for(milliseconds(2));
        --now;
        ++done;
      });
    }
    while (done < kTasks) std::this_thread::sleep_for(milliseconds(1));
    return most.load();
  };
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (most_at_once() > 2) ASSERT_LT(std::chrono::steady_clock::now(), give_up);
}

TEST(WorkerPool, RunsTimedTasksInOrderOfTheirTimeAndNotBefore) {
  WorkerPool pool(1);
  const auto now = WorkerPool::Clock::now();
  std::vector<int> order;
  std::promise<WorkerPool::Clock::time_point> last;

  pool.PostAt(now + milliseconds(60), [&] {
    order.push_back(3);
    last.set_value(WorkerPool::Clock::now());
  });
  pool.PostAt(now + milliseconds(20), [&] { order.push_back(1); });
  pool.PostAt(now + milliseconds(40), [&] { order.push_back(2); });
  auto future = last.get_future();
  ASSERT_EQ(future.wait_for(kPatience), std::future_status::ready);

  EXPECT_GE(future.get(), now + milliseconds(60));
  EXPECT_EQ(order, (std::vector<int>{1, 2, 3}));
}

TEST(WorkerPool, SurvivesATaskThatThrows) {
  WorkerPool pool(1);
  std::promise<void> done;

  pool.Post([] { throw std::runtime_error("on purpose"); });
  pool.Post([&] { done.set_value(); });

  EXPECT_EQ(done.get_future().wait_for(kPatience), std::future_status::ready);
}

TEST(WorkerPool, IsShortWhileATaskWaitsThatNoIdleWorkerTakes) {
  WorkerPool pool(1);
  std::promise<void> begun, released, done;
  pool.Post([&] {
    begun.set_value();
    released.get_future().wait();
  });
  ASSERT_EQ(begun.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_FALSE(pool.IsShort());
  pool.Post([&] { done.set_value(); });
  EXPECT_TRUE(pool.IsShort());
  released.set_value();
  ASSERT_EQ(done.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_FALSE(pool.IsShort());
}

// The world is in that processor's caches.
TEST(Strand, StaysOnItsWorkerWhileNobodyWaitsForIt) {
  constexpr int kPosts = 20;
  WorkerPool pool(2);
  const auto strand = std::make_shared<Strand>(pool);
  std::vector<std::thread::id> threads;
  std::promise<void> done;
  std::function<Progress()> work = [&] {
    threads.push_back(std::this_thread::get_id());
    std::this_thread::sleep_for(2 * kSlice);
    if (threads.size() < kPosts) {
      strand->Post(work);
    } else {
      done.set_value();
    }
    return Progress::kDone;
  };
  strand->Post(work);
  ASSERT_EQ(done.get_future().wait_for(kPatience), std::future_status::ready);
  Settle(*strand);
  for (const std::thread::id thread : threads) EXPECT_EQ(thread, threads.front());
}

TEST(Strand, DoesItsWorkInOrderAndNeverTwoAtATime) {
  constexpr int kPosts = 2000;
  WorkerPool pool(4);
  const auto strand = std::make_shared<Strand>(pool);
  std::vector<int> order;  // unguarded on purpose: a race would show
  for (int i = 0; i < kPosts; ++i) {
    strand->Post([&, i] {
      order.push_back(i);
      return Progress::kDone;
    });
  }
  Settle(*strand);

  ASSERT_EQ(order.size(), size_t{kPosts});
  for (int i = 0; i < kPosts; ++i) EXPECT_EQ(order[static_cast<size_t>(i)], i);
}

TEST(Strand, LetsOthersHaveTheirTurnBetweenTheSlicesOfLongWork) {
  constexpr int kSlices = 100;
  WorkerPool pool(1);
  const auto busy = std::make_shared<Strand>(pool), other = std::make_shared<Strand>(pool);
  std::promise<void> begun;
  std::atomic<int> slices = 0, slices_before_other = -1;
  busy->Post([&] {
    if (slices == 0) {
      begun.set_value();
      // The other strand's work is posted before the second slice.
      while (slices_before_other == -1) std::this_thread::yield();
    }
    return ++slices < kSlices ? Progress::kAgain : Progress::kDone;
  });
  begun.get_future().wait();
  other->Post([&] {
    slices_before_other = slices.load();
    return Progress::kDone;
  });
  slices_before_other = -2;
  Settle(*busy);

  EXPECT_EQ(slices, kSlices);
  EXPECT_EQ(slices_before_other, 1);
}

TEST(Strand, KeepsTheOrderAroundWorkThatTakesManySlices) {
  WorkerPool pool(2);
  const auto strand = std::make_shared<Strand>(pool);
  int slices = 0, slices_seen_by_next = 0;
  strand->Post([&] { return ++slices < 10 ? Progress::kAgain : Progress::kDone; });
  strand->Post([&] {
    slices_seen_by_next = slices;
    return Progress::kDone;
  });
  Settle(*strand);

  EXPECT_EQ(slices_seen_by_next, 10);
}

TEST(Strand, RunsWorkOnTheCallersThreadOnlyWhileNothingElseIsThere) {
  WorkerPool pool(1);
  const auto strand = std::make_shared<Strand>(pool);
  std::promise<void> gate, begun;
  std::vector<std::thread::id> threads;
  const auto note = [&] {
    threads.push_back(std::this_thread::get_id());
    return Progress::kDone;
  };

  strand->RunOrPost(note);
  EXPECT_EQ(threads, std::vector{std::this_thread::get_id()});
  strand->Post([&] {
    begun.set_value();
    gate.get_future().wait();
    return Progress::kDone;
  });
  begun.get_future().wait();
  strand->RunOrPost(note);
  EXPECT_EQ(threads.size(), 1u);
  gate.set_value();
  Settle(*strand);

  ASSERT_EQ(threads.size(), 2u);
  EXPECT_NE(threads[1], std::this_thread::get_id());
}

TEST(Strand, HandsOnWhatIsLeftOfTheWorkThatTheCallerBegan) {
  WorkerPool pool(1);
  const auto strand = std::make_shared<Strand>(pool);
  std::vector<std::thread::id> threads;

  strand->RunOrPost([&] {
    threads.push_back(std::this_thread::get_id());
    return threads.size() < 3 ? Progress::kAgain : Progress::kDone;
  });
  Settle(*strand);

  ASSERT_EQ(threads.size(), 3u);
  EXPECT_EQ(threads[0], std::this_thread::get_id());
  EXPECT_NE(threads[1], threads[0]);
}

TEST(Strand, DoesUrgentTasksBetweenTwoSlices) {
  WorkerPool pool(1);
  const auto strand = std::make_shared<Strand>(pool);
  std::atomic<bool> urgent_done = false;
  std::atomic<bool> posted = false;
  int slices = 0;
  std::promise<void> begun;
  strand->Post([&] {
    if (++slices == 1) begun.set_value();
    while (!posted) std::this_thread::yield();
    return urgent_done ? Progress::kDone : Progress::kAgain;
  });
  begun.get_future().wait();
  strand->PostUrgent([&] { urgent_done = true; });
  posted = true;
  Settle(*strand);

  EXPECT_EQ(slices, 2);
}

}  // namespace
}  // namespace genphys

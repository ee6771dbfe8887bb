#include "genphys/hosting/frame_hub.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "genphys/v1/simulation_service.pb.h"
#include "genphys/wire/encode_frame.h"
#include "support/scenes.h"

namespace genphys {
namespace {

// A world without an engine, whose steps are shown by hand.
class FramesOfAWorld : public ::testing::Test {
 protected:
  FramesOfAWorld() {
    for (int i = 0; i < kBalls; ++i) {
      balls_.push_back(testing::Add(*world_, testing::Body(Sphere{0.5}, Vector3(3.0 * i, 0, 0.5))));
    }
  }

  void Show(uint64_t step) {
    const Command command = SetPose{.id = balls_[0], .position = Vector3(static_cast<double>(step), 0, 0)};
    testing::Do(*world_, command);
    keyframes_.FollowCommands(*world_, {&command, 1});
    stamp_.step = step;
    hub_->Publish(*world_, stamp_, keyframes_);
  }
  // Of all but the last `without` balls.
  v1::FrameRequest Wanted(size_t without) const {
    v1::FrameRequest request;
    request.set_poses(true);
    for (size_t i = 0; i + without < balls_.size(); ++i) request.add_entity_ids(balls_[i].packed());
    return request;
  }
  std::shared_ptr<Subscription> Watch(const v1::FrameRequest& wanted, uint32_t every_nth_step) {
    v1::WatchFramesRequest request;
    request.set_world("worlds/w");
    *request.mutable_frame() = wanted;
    request.set_every_nth_step(every_nth_step);
    return hub_->Watch(MakeBytes(request.SerializeAsString()));
  }
  v1::Frame Next(Subscription& view) {
    std::promise<Delivery> promise;
    view.Next([&](Delivery delivery) { promise.set_value(std::move(delivery)); });
    std::future<Delivery> future = promise.get_future();
    // The hub asks for the present, which nobody tells on its own here.
    while (future.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready) {
      hub_->PublishCurrent(*world_, stamp_, keyframes_);
    }
    v1::WatchFramesResponse response;
    EXPECT_TRUE(response.ParseFromString(Joined(future.get().message.value_or(EncodedMessage()))));
    return response.frame();
  }
  static double FirstPlace(const v1::Frame& frame) {
    double x = 0;
    frame.positions().copy(reinterpret_cast<char*>(&x), sizeof x);
    return x;
  }

  static constexpr int kBalls = 2000;
  std::unique_ptr<World> world_ = testing::MakeWorld("none");
  std::vector<EntityId> balls_;
  WorkerPool pool_{2};
  std::shared_ptr<FrameHub> hub_ = std::make_shared<FrameHub>(pool_, [] {});
  Keyframes keyframes_;
  Stamp stamp_{0, 0, 1, {}};
};

TEST_F(FramesOfAWorld, AreThoseOfTheLastStepThatWasDueWhenAViewerComesBack) {
  for (const bool deltas : {false, true}) {
    v1::FrameRequest wanted = Wanted(0);
    wanted.set_deltas(deltas);
    const auto view = Watch(wanted, 4);
    const uint64_t from = stamp_.step;
    Next(*view);

    for (uint64_t step = from + 1; step <= from + 11; ++step) Show(step);

    const v1::Frame frame = Next(*view);
    EXPECT_EQ(frame.stamp().step(), from + 8);
    EXPECT_EQ(FirstPlace(frame), static_cast<double>(from + 8));
    EXPECT_EQ(frame.skipped_frames(), 1u);
    Show(from + 12);
    EXPECT_EQ(FirstPlace(Next(*view)), static_cast<double>(from + 12));
  }
}

// Who does not read costs nothing that grows with how many want what: a copy of the state, for all.
TEST_F(FramesOfAWorld, AreNotEncodedForViewersWhoDoNotComeBack) {
  constexpr size_t kViewers = 64;
  std::vector<std::shared_ptr<Subscription>> views;
  for (size_t i = 0; i < kViewers; ++i) {
    views.push_back(Watch(Wanted(i), 2));
    Next(*views.back());
  }
  const auto shortest = [](const auto& work) {
    auto best = std::chrono::steady_clock::duration::max();
    for (int i = 0; i < 20; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      work();
      best = std::min(best, std::chrono::steady_clock::now() - begin);
    }
    return best;
  };
  const v1::FrameRequest wanted = Wanted(0);

  const auto shown = shortest([&] { Show(stamp_.step + 2); });
  const auto encoded = shortest([&] {
    const FrameEncoder frame(*world_, wanted);
    std::string bytes(frame.size(), '\0');
    frame.Write(bytes.data());
  });

  EXPECT_LT(shown, kViewers / 4 * encoded);
}

// Whoever comes while its next frame is being made takes what was kept for it: what follows is against that.
TEST_F(FramesOfAWorld, AreAgainstTheKeyframeThatTheViewerWasSentLast) {
  const auto place = [&](double x, double others) {
    std::vector<Command> commands;
    for (size_t i = 0; i < 3; ++i) {
      commands.push_back(SetPose{.id = balls_[i], .position = Vector3(i == 0 ? x : others, 0, 0)});
    }
    for (const Command& command : commands) testing::Do(*world_, command);
    keyframes_.FollowCommands(*world_, commands);
    ++stamp_.step;
    hub_->Publish(*world_, stamp_, keyframes_);
  };
  place(0, 0);
  const auto witness = Watch(Wanted(balls_.size() - 1), 1);
  Next(*witness);
  v1::FrameRequest wanted = Wanted(balls_.size() - 3);
  wanted.set_deltas(true);
  const auto view = Watch(wanted, 1);
  const uint64_t first = Next(*view).keyframe_id();
  std::vector<v1::Frame> frames;
  const Subscription::Receiver receive = [&](Delivery delivery) {
    v1::WatchFramesResponse response;
    ASSERT_TRUE(response.ParseFromString(Joined(delivery.message.value_or(EncodedMessage()))));
    frames.push_back(response.frame());
  };

  place(1, 1);  // all differ, so that a new keyframe waits for the viewer
  Next(*witness);
  // One differs from the first keyframe. The witness is told on this thread, before the viewer is.
  witness->Next([&](const Delivery&) { view->Next(receive); });
  place(2, 0);
  view->Next(receive);

  ASSERT_EQ(frames.size(), 2u);
  EXPECT_FALSE(frames[0].has_keyframe_step());
  EXPECT_NE(frames[0].keyframe_id(), first);
  EXPECT_EQ(frames[0].skipped_frames(), 0u);
  EXPECT_EQ(frames[1].stamp().step(), stamp_.step);
  EXPECT_EQ(frames[1].skipped_frames(), 0u);
  EXPECT_TRUE(!frames[1].has_keyframe_step() || frames[1].keyframe_id() == frames[0].keyframe_id());
}

}  // namespace
}  // namespace genphys

#include "genphys/hosting/keyframes.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "support/scenes.h"

namespace genphys {
namespace {

class KeyframesOfAWorld : public ::testing::Test {
 protected:
  static constexpr int kBalls = 10;

  KeyframesOfAWorld() { Fill(AutoDisable{.enabled = false}); }

  // Everybody floats where it is.
  void Fill(const AutoDisable& auto_disable) {
    WorldDesc desc{.engine = testing::EnginesWithContacts().front(), .gravity = Vector3::Zero()};
    desc.ground_plane = false;
    desc.default_auto_disable = auto_disable;
    world_ = testing::MakeWorld(desc);
    balls_.clear();
    for (int i = 0; i < kBalls; ++i) {
      balls_.push_back(testing::Add(*world_, testing::Body(Sphere{0.5}, Vector3(3.0 * i, 0, 0.5))));
    }
  }

  void Step() {
    ASSERT_TRUE(world_->Step().ok());
    keyframes_.FollowStep(*world_);
  }
  void Apply(const Command& command) {
    ASSERT_TRUE(world_->Apply({&command, 1}).ok());
    keyframes_.FollowCommands(*world_, {&command, 1});
  }
  v1::Frame Encode(uint64_t base, const v1::FrameRequest& request = Poses()) {
    v1::WorldStamp stamp;
    stamp.set_step(world_->layer_state().step);
    const Keyframes::Encoded encoded = keyframes_.Encode(*world_, request, stamp, base);
    v1::Frame frame;
    EXPECT_TRUE(frame.ParseFromString(Joined(encoded.frame)));
    EXPECT_EQ(frame.keyframe_id(), encoded.keyframe_id);
    return frame;
  }
  static v1::FrameRequest Poses() {
    v1::FrameRequest request;
    request.set_poses(true);
    request.set_deltas(true);
    return request;
  }
  // One of many kinds of frame.
  static v1::FrameRequest Kind(uint64_t number) {
    v1::FrameRequest request = Poses();
    request.add_entity_ids(number + 1000);
    return request;
  }

  std::unique_ptr<World> world_;
  std::vector<EntityId> balls_;
  Keyframes keyframes_;
};

TEST_F(KeyframesOfAWorld, AreOneForAllThatAreMadeOfTheSameMoment) {
  const uint64_t first = Encode(0).keyframe_id();

  EXPECT_EQ(Encode(0).keyframe_id(), first);
  EXPECT_NE(Encode(0, Kind(0)).keyframe_id(), first);
  Step();
  EXPECT_NE(Encode(0).keyframe_id(), first);
}

TEST_F(KeyframesOfAWorld, TellWhatACommandChangedThoughNobodyWakes) {
  const uint64_t base = Encode(0).keyframe_id();

  Apply(SetPose{.id = balls_[4], .position = Vector3(0, 30, 0.5)});

  const v1::Frame delta = Encode(base);
  EXPECT_EQ(delta.keyframe_id(), base);
  EXPECT_EQ(delta.entity_ids().size(), sizeof(uint64_t));
}

TEST_F(KeyframesOfAWorld, TellWhoWokeAndSleptAgainWithinAStep) {
  Fill(AutoDisable{.enabled = true, .rest_time = 0});
  Step();
  ASSERT_TRUE(world_->IsAtRest());
  const double gap = 5e-5;
  Apply(SetPose{.id = balls_[4], .position = Vector3(3.0 * 5 - 1 - gap, 0, 0.5)});
  // So slow that both rest again at once.
  Apply(SetVelocity{.id = balls_[4], .linear = Vector3(0.015, 0, 0)});
  const uint64_t base = Encode(0).keyframe_id();

  Step();

  ASSERT_TRUE(world_->IsAtRest());
  ASSERT_GT(world_->state().positions(0, balls_[5].index()), 3.0 * 5);
  const v1::Frame delta = Encode(base);
  EXPECT_EQ(delta.keyframe_id(), base);
  EXPECT_EQ(delta.entity_ids().size(), 2 * sizeof(uint64_t));
}

TEST_F(KeyframesOfAWorld, AreNotThoseOfAnotherWorldOrAnotherEpoch) {
  const uint64_t base = Encode(0).keyframe_id();
  keyframes_.Clear();

  const v1::Frame frame = Encode(base);

  EXPECT_FALSE(frame.has_keyframe_step());
  EXPECT_NE(frame.keyframe_id(), base);
  Keyframes others;
  v1::WorldStamp stamp;
  EXPECT_NE(others.Encode(*world_, Poses(), stamp, 0).keyframe_id, frame.keyframe_id());
}

TEST_F(KeyframesOfAWorld, AreForgottenWhenTheyAreTooMany) {
  const uint64_t used = Encode(0).keyframe_id(), unused = Encode(0, Kind(0)).keyframe_id();
  for (uint64_t i = 1; i < Keyframes::kKeyframesMax; ++i) {
    Step();
    Encode(0, Kind(i));
    EXPECT_EQ(Encode(used).keyframe_id(), used);
  }

  EXPECT_EQ(Encode(used).keyframe_id(), used);
  EXPECT_NE(Encode(unused, Kind(0)).keyframe_id(), unused);
}

TEST_F(KeyframesOfAWorld, AreForgottenWhenNobodyUsesThemAnyMore) {
  const uint64_t base = Encode(0).keyframe_id();
  for (uint64_t i = 0; i < Keyframes::kUnusedChangesMax; ++i) Step();
  EXPECT_EQ(Encode(base).keyframe_id(), base);

  for (uint64_t i = 0; i < Keyframes::kUnusedChangesMax + 1; ++i) Step();

  EXPECT_NE(Encode(base).keyframe_id(), base);
}

TEST_F(KeyframesOfAWorld, TellWhoArrivedAtTheEndOfItsWay) {
  // In the middle of its way, and before one that is too long to be gone.
  for (const auto& [way, steps] : {std::pair(1.0, 1), std::pair(1e6, 0)}) {
    Fill(AutoDisable{.enabled = false});
    EntityDesc lift = testing::Body(Sphere{0.5}, Vector3(0, 100, 0));
    lift.rigid_body->motion_type = MotionType::kKinematic;
    const EntityId led = testing::Add(*world_, lift);
    Apply(SetPose{.id = led, .position = Vector3(0, 100, way), .over_steps = 3});
    for (int i = 0; i < steps; ++i) Step();
    v1::FrameRequest request = Poses();
    request.set_velocities(true);
    const uint64_t base = Encode(0, request).keyframe_id();

    for (int i = 0; i < 5; ++i) Step();

    ASSERT_EQ(world_->state().positions(2, led.index()), way);
    ASSERT_TRUE(world_->state().linear_velocities.col(led.index()).isZero(0));
    const v1::Frame delta = Encode(base, request);
    EXPECT_EQ(delta.keyframe_id(), base);
    EXPECT_EQ(delta.entity_ids().size(), sizeof(uint64_t)) << way;
  }
}

}  // namespace
}  // namespace genphys

#include "genphys/hosting/frame_bodies.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "support/scenes.h"

namespace genphys {
namespace {

v1::FrameRequest Poses() {
  v1::FrameRequest request;
  request.set_poses(true);
  return request;
}

v1::FrameRequest PosesAndVelocities() {
  v1::FrameRequest request = Poses();
  request.set_velocities(true);
  return request;
}

class FrameBodiesOfAWorld : public ::testing::TestWithParam<std::string> {
 protected:
  FrameBodiesOfAWorld() {
    world_ = testing::MakeWorld(WorldDesc{.engine = GetParam()});
    ball_ = testing::Add(*world_, testing::Body(Sphere{0.5}, Vector3(0, 0, 0.5)));
  }

  void StepUntilAsleep() {
    for (int i = 0; i < 600 && !world_->state().asleep[ball_.index()]; ++i) ASSERT_TRUE(world_->Step().ok());
    ASSERT_TRUE(world_->state().asleep[ball_.index()]);
  }
  void Apply(const Command& command) { ASSERT_TRUE(world_->Apply({&command, 1}).ok()); }
  // Asked for twice, so that the second is kept if anything is.
  const void* Kept(const v1::FrameRequest& request = Poses()) {
    bodies_.Encode(*world_, request);
    return bodies_.Encode(*world_, request).view.data();
  }
  const void* Again(const v1::FrameRequest& request = Poses()) { return bodies_.Encode(*world_, request).view.data(); }
  v1::Frame Decoded() {
    v1::Frame frame;
    EXPECT_TRUE(frame.ParseFromString(std::string(bodies_.Encode(*world_, Poses()).view)));
    return frame;
  }

  std::unique_ptr<World> world_;
  EntityId ball_;
  FrameBodies bodies_;
};

TEST_P(FrameBodiesOfAWorld, AreSharedWhileAllSleep) {
  StepUntilAsleep();
  const void* const kept = Kept();

  ASSERT_TRUE(world_->Step().ok());

  EXPECT_EQ(Again(), kept);
  EXPECT_NE(Kept(PosesAndVelocities()), kept);
  EXPECT_EQ(Again(), kept);
}

TEST_P(FrameBodiesOfAWorld, TellOfWhatMovedAfterTheyWereKept) {
  StepUntilAsleep();
  Kept();
  Apply(SetVelocity{ball_, Vector3(1, 0, 0), std::nullopt});
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(world_->Step().ok());
    const v1::Frame frame = Decoded();

    // Nobody was deleted, so that rows are those of the state.
    double x = 0;
    const size_t at = ball_.index() * 3 * sizeof x;
    ASSERT_GE(frame.positions().size(), at + sizeof x);
    std::memcpy(&x, frame.positions().data() + at, sizeof x);
    EXPECT_EQ(x, world_->state().positions(0, ball_.index()));
    EXPECT_GT(x, 0);
  }
}

TEST_P(FrameBodiesOfAWorld, TellOfWhatACommandChangedBetweenSteps) {
  StepUntilAsleep();
  Kept();

  testing::Add(*world_, testing::Body(Sphere{0.5}, Vector3(5, 0, 0.5)));
  EXPECT_EQ(Decoded().entity_ids().size(), 3 * sizeof(EntityId));

  Kept();
  Apply(DeleteEntity{ball_});
  EXPECT_EQ(Decoded().entity_ids().size(), 2 * sizeof(EntityId));

  Kept();
  world_->Reset();
  EXPECT_EQ(Decoded().entity_ids().size(), 2 * sizeof(EntityId));
}

TEST_P(FrameBodiesOfAWorld, DoNotKeepMoreKindsThanTheyMay) {
  StepUntilAsleep();
  std::vector<v1::FrameRequest> kinds(FrameBodies::kKeptMax + 1, Poses());
  for (size_t i = 0; i < kinds.size(); ++i) {
    kinds[i].add_entity_ids(ball_.packed());
    kinds[i].add_entity_ids(1000 + i);
  }
  for (const v1::FrameRequest& kind : kinds) Kept(kind);

  const Bytes first = bodies_.Encode(*world_, kinds.front());
  const Bytes last = bodies_.Encode(*world_, kinds.back());

  EXPECT_GT(first.owner.use_count(), 1);
  EXPECT_EQ(last.owner.use_count(), 1);
}

INSTANTIATE_TEST_SUITE_P(Engines, FrameBodiesOfAWorld, ::testing::ValuesIn(testing::EnginesWithContacts()));

}  // namespace
}  // namespace genphys

// The memory that frames of the C++ client lie in is used again: nobody may notice but the clock.
#include <gtest/gtest.h>

#include <optional>

#include "integration/live_server.h"

namespace genphys::testing {
namespace {

class ClientFrames : public ::testing::Test {
 protected:
  ClientFrames() {
    for (int i = 0; i < 100; ++i) Value(world_.Add(Sphere{0.1}, {.position = {double(i), 0, 5}, .mass = 1}));
  }

  const LiveServer live_;
  client::Server server_ = live_.Connect();
  client::World world_ = Value(server_.CreateWorld({}));
};

TEST_F(ClientFrames, StayAsTheyAreWhileLaterOnesCome) {
  const client::StepResult first = Value(world_.Step());
  const Eigen::Matrix3Xd positions = first.frame.positions();

  for (int i = 0; i < 5; ++i) {
    const client::StepResult later = Value(world_.Step(10));
    EXPECT_NE(later.frame.positions().data(), first.frame.positions().data());
    EXPECT_LT(later.frame.positions()(2, 50), positions(2, 50));
  }

  EXPECT_EQ(first.frame.positions(), positions);
}

TEST_F(ClientFrames, ComeWhereThoseWereThatNobodyHoldsAnyMore) {
  const auto place = [&] { return Value(world_.Step()).frame.positions().data(); };
  const double* const first = place();

  EXPECT_EQ(place(), first);
  EXPECT_EQ(place(), first);
}

TEST_F(ClientFrames, AreEmptyWhereNoneWasAskedForAndTheNextIsWhole) {
  Value(world_.Step());

  const client::StepResult without = Value(world_.Step(1, {.frame = std::nullopt}));
  EXPECT_EQ(without.frame.rows(), 0u);
  EXPECT_EQ(without.stamp.step, 2u);

  const client::StepResult poses = Value(world_.Step(1, {.frame = client::FrameOptions{.velocities = false}}));
  EXPECT_GE(poses.frame.positions().cols(), 100);
  EXPECT_EQ(poses.frame.linear_velocities().cols(), 0);
}

TEST_F(ClientFrames, OfARefusedStepDoNotReachTheNextOne) {
  Value(world_.Step());

  EXPECT_FALSE(world_.Step(1, {.expected_step = 77}).ok());

  EXPECT_EQ(Value(world_.Step()).stamp.step, 2u);
}

TEST_F(ClientFrames, OutliveTheirConnection) {
  std::optional<client::Frame> frame;
  {
    const client::Server server = live_.Connect();
    client::World world = Value(server.CreateWorld({}));
    Value(world.Add(Sphere{0.5}, {.position = {1, 2, 3}, .mass = 1}));
    frame = Value(world.Step(0)).frame;
  }

  EXPECT_EQ(frame->positions().col(frame->rows() - 1), Vector3(1, 2, 3));
}

}  // namespace
}  // namespace genphys::testing

// Streams of the C++ client: what a slow viewer sees.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "integration/live_server.h"

namespace genphys::testing {
namespace {

class ClientFrameStream : public ::testing::TestWithParam<bool> {};

TEST_P(ClientFrameStream, HasTheNewestForAViewerThatWasBusyAndCountsTheRest) {
  // Far less than what fits into the windows of a connection.
  constexpr uint64_t kSteps = 50;
  constexpr std::chrono::milliseconds kLook(10);
  const LiveServer live;
  client::World world = Value(live.Connect().CreateWorld({}));
  for (int i = 0; i < 20; ++i) Value(world.Add(Sphere{0.1}, {.position = {double(i), 0, 5}, .mass = 1}));
  client::FrameStream frames = Value(world.WatchFrames({.deltas = GetParam()}));
  client::Frame seen = *Value(frames.Next());

  for (uint64_t round = 1; round <= 3; ++round) {
    client::Frame stepped;
    for (uint64_t i = 0; i < kSteps; ++i) stepped = Value(world.Step()).frame;
    // Until they are there.
    std::this_thread::sleep_for(50 * kLook);
    const client::Frame newest = *Value(frames.Next());

    EXPECT_EQ(newest.stamp().step, round * kSteps);
    EXPECT_EQ(newest.skipped_frames(), newest.stamp().step - seen.stamp().step - 1);
    EXPECT_EQ(newest.positions(), stepped.positions());
    seen = newest;
  }
}

INSTANTIATE_TEST_SUITE_P(WholeAndDeltas, ClientFrameStream, ::testing::Bool());

}  // namespace
}  // namespace genphys::testing

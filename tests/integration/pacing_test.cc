// Worlds that move by themselves.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Worlds = v1::WorldService::Stub;
using std::chrono::steady_clock;

v1::PlayWorldResponse Play(TestServer& server, const std::string& world, double factor) {
  v1::PlayWorldRequest request;
  request.set_name(world);
  request.set_real_time_factor(factor);
  return Must(server.worlds(), &Worlds::PlayWorld, request);
}

v1::PauseWorldResponse Pause(TestServer& server, const std::string& world) {
  v1::PauseWorldRequest request;
  request.set_name(world);
  return Must(server.worlds(), &Worlds::PauseWorld, request);
}

v1::GetWorldResponse Get(TestServer& server, const std::string& world) {
  v1::GetWorldRequest request;
  request.set_name(world);
  return Must(server.worlds(), &Worlds::GetWorld, request);
}

void WaitForStep(TestServer& server, const std::string& world, uint64_t step) {
  const auto give_up = steady_clock::now() + kPatience;
  while (Get(server, world).stamp().step() < step) {
    ASSERT_LT(steady_clock::now(), give_up) << "the world does not move";
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

TEST(PlayWorld, MovesAtTheFactorUntilItIsPaused) {
  // Slower than asked for is what a busy machine does to any clock; faster would be wrong on every machine.
  constexpr double kFactor = 4;
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  const auto begin = steady_clock::now();

  Play(server, world, kFactor);
  EXPECT_EQ(Get(server, world).world().state(), v1::World::STATE_PLAYING);
  WaitForStep(server, world, 60);
  const auto paused = Pause(server, world);

  const std::chrono::duration<double> elapsed = steady_clock::now() - begin;
  EXPECT_GE(elapsed.count() * kFactor, paused.stamp().simulation_time_seconds());
  EXPECT_EQ(Get(server, world).world().state(), v1::World::STATE_PAUSED);
  EXPECT_EQ(Get(server, world).stamp().step(), paused.stamp().step());
  EXPECT_EQ(server.Step(world).stamp().step(), paused.stamp().step() + 1);
}

TEST(PlayWorld, WithFactorZeroMovesAsFastAsItCanAndStillAnswers) {
  TestServer server(ServerOptions{.workers = 1});
  const std::string world = server.CreateWorld().world().name();
  Play(server, world, 0);

  WaitForStep(server, world, 1000);
  server.AddBall(world, 4);

  EXPECT_GE(Pause(server, world).stamp().step(), 1000u);
}

TEST(PlayWorld, LeavesCommandsToClientsAndStepsToTheWorld) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  Play(server, world, 1);
  v1::StepRequest request;
  request.set_world(world);

  ExpectRefusal(MustNot(server.simulation(), &v1::SimulationService::Stub::Step, request), Reason::kWorldNotPaused, "");
  request.set_steps(0);
  request.add_commands()->mutable_set_gravity()->mutable_gravity()->set_z(-1);
  Must(server.simulation(), &v1::SimulationService::Stub::Step, request);
}

TEST(PlayWorld, ShowsItsFramesToViewers) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  v1::WatchFramesRequest request;
  request.set_world(world);
  const auto reader = server.simulation().WatchFrames(&context, request);

  Play(server, world, 2);
  v1::WatchFramesResponse response;
  uint64_t steps = 0;
  while (steps < 10 && reader->Read(&response)) {
    EXPECT_GE(response.frame().stamp().step(), steps);
    steps = response.frame().stamp().step();
  }

  EXPECT_GE(steps, 10u);
  context.TryCancel();
  reader->Finish();
}

// A world in which nothing moves is left alone for seconds. Nobody may notice.
class WorldAtRest : public ::testing::Test {
 protected:
  static constexpr double kFactor = 10;
  // Much less than it is left alone.
  static constexpr std::chrono::seconds kSoon{5};

  WorldAtRest() {
    Play(server_, world_, kFactor);
    // The first step finds that nothing moves.
    WaitForStep(server_, world_, 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }

  TestServer server_;
  const std::string world_ = server_.CreateWorld().world().name();
};

TEST_F(WorldAtRest, IsAtItsTimeWhenSomebodyLooks) {
  const double before = Get(server_, world_).stamp().simulation_time_seconds();
  const auto begin = steady_clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(800));
  const std::chrono::duration<double> elapsed = steady_clock::now() - begin;

  const double gone = Get(server_, world_).stamp().simulation_time_seconds() - before;

  // A machine that stalled before the rest began may have left a quarter of a second behind.
  EXPECT_GE(gone, kFactor * (elapsed.count() - 0.25) - 1.0 / 60);
}

TEST_F(WorldAtRest, GoesOnAtOnceWithWhatIsPutIntoIt) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  v1::WatchEventsRequest request;
  request.set_world(world_);
  const auto reader = server_.simulation().WatchEvents(&context, request);
  const auto begin = steady_clock::now();
  server_.AddBall(world_, 4);

  bool has_landed = false;
  v1::WatchEventsResponse response;
  while (!has_landed && reader->Read(&response)) {
    for (const v1::Event& event : response.batch().events()) has_landed |= event.has_contact_began();
  }

  EXPECT_TRUE(has_landed);
  EXPECT_LT(steady_clock::now() - begin, kSoon);
  context.TryCancel();
  reader->Finish();
}

TEST_F(WorldAtRest, ShowsEveryFrameToAViewerWhoComes) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  v1::WatchFramesRequest request;
  request.set_world(world_);
  const auto begin = steady_clock::now();
  const auto reader = server_.simulation().WatchFrames(&context, request);

  v1::WatchFramesResponse response;
  for (int frame = 0; frame < 5; ++frame) ASSERT_TRUE(reader->Read(&response));

  EXPECT_LT(steady_clock::now() - begin, kSoon);
  context.TryCancel();
  reader->Finish();
}

TEST_F(WorldAtRest, IsPausedAtItsTime) {
  const double before = Get(server_, world_).stamp().simulation_time_seconds();
  std::this_thread::sleep_for(std::chrono::milliseconds(600));

  EXPECT_GE(Pause(server_, world_).stamp().simulation_time_seconds() - before, kFactor * 0.35 - 1.0 / 60);
}

TEST(ResetWorld, PausesAWorldThatPlays) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  Play(server, world, 10);
  WaitForStep(server, world, 10);
  v1::ResetWorldRequest request;
  request.set_name(world);

  Must(server.worlds(), &Worlds::ResetWorld, request);

  EXPECT_EQ(Get(server, world).world().state(), v1::World::STATE_PAUSED);
  EXPECT_EQ(Get(server, world).stamp().step(), 0u);
}

TEST(DeleteWorld, EndsAWorldThatPlays) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  Play(server, world, 0);
  WaitForStep(server, world, 10);
  v1::DeleteWorldRequest request;
  request.set_name(world);

  Must(server.worlds(), &Worlds::DeleteWorld, request);

  v1::GetWorldRequest get;
  get.set_name(world);
  ExpectRefusal(MustNot(server.worlds(), &Worlds::GetWorld, get), Reason::kWorldNotFound, "name");
}

}  // namespace
}  // namespace genphys::testing

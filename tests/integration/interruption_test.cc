// Long calls: how they end early, and what they leave to others.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <future>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "genphys/wire/early_end.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;

// A pile that takes minutes for all these steps, on any machine.
constexpr uint32_t kManySteps = 100000;
constexpr int kPile = 60;

std::string MakePile(TestServer& server) {
  const std::string world = server.CreateWorld().world().name();
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  for (int i = 0; i < kPile; ++i) {
    v1::Entity& box = *request.add_commands()->mutable_create_entity()->mutable_entity();
    v1::RigidBody& body = *box.mutable_rigid_body();
    body.mutable_auto_disable()->set_enabled(false);
    v1::Vector3& half = *body.add_geometries()->mutable_shape()->mutable_box()->mutable_half_extents();
    half.set_x(0.5), half.set_y(0.5), half.set_z(0.5);
    box.mutable_pose()->mutable_position()->set_x(1.1 * (i % 4));
    box.mutable_pose()->mutable_position()->set_z(0.5 + i / 4);
  }
  Must(server.simulation(), &Simulation::Step, request);
  return world;
}

v1::StepRequest ManySteps(const std::string& world) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(kManySteps);
  return request;
}

uint64_t StepOf(TestServer& server, const std::string& world) {
  v1::GetWorldRequest request;
  request.set_name(world);
  return Must(server.worlds(), &v1::WorldService::Stub::GetWorld, request).stamp().step();
}

v1::Entity Ball(double x) {
  v1::Entity ball;
  ball.mutable_pose()->mutable_position()->set_x(x);
  ball.mutable_pose()->mutable_position()->set_z(5);
  ball.mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere();
  return ball;
}

// Once a call ended early, the world stands still between two steps: where, is not known beforehand.
uint64_t StepAtRest(TestServer& server, const std::string& world) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  return Must(server.simulation(), &Simulation::Step, request).stamp().step();
}

void WaitForStep(TestServer& server, const std::string& world, uint64_t step) {
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (StepOf(server, world) < step) {
    ASSERT_LT(std::chrono::steady_clock::now(), give_up) << "the world does not move";
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

// How long until a machine, however busy, has made a step of a pile and told of it: found by trying.
constexpr std::chrono::milliseconds kShort{300};

TEST(LongStep, StopsAtItsDeadlineAndKeepsWhatIsDone) {
  TestServer server;
  const std::string world = MakePile(server);
  uint64_t step = 0;
  for (auto time = kShort; step == 0; time *= 2) {
    ASSERT_LT(time, kPatience) << "no step is kept";
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + time);
    v1::StepResponse response;

    const grpc::Status status = server.simulation().Step(&context, ManySteps(world), &response);

    ASSERT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
    step = StepAtRest(server, world);
  }
  EXPECT_LT(step, kManySteps);
  EXPECT_EQ(server.Step(world).stamp().step(), step + 1);
}

TEST(LongStep, TellsBeforeItsDeadlineHowFarItCame) {
  TestServer server;
  const std::string world = MakePile(server);
  for (auto time = kShort; time < kPatience; time *= 2) {
    const uint64_t before = StepAtRest(server, world);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + time);
    v1::StepRequest request = ManySteps(world);
    request.add_commands()->mutable_set_gravity()->mutable_gravity()->set_z(-9);
    request.add_commands()->mutable_create_entity()->mutable_entity();
    v1::StepResponse response;
    const grpc::Status status = server.simulation().Step(&context, request, &response);
    ASSERT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
    google::rpc::Status details;
    ASSERT_TRUE(details.ParseFromString(status.error_details()));
    const uint64_t step = StepAtRest(server, world);
    if (details.details_size() == 0 || step == before) continue;
    google::rpc::ErrorInfo info;
    ASSERT_TRUE(details.details(0).UnpackTo(&info));
    EXPECT_EQ(info.metadata().at("step"), std::to_string(step));
    EXPECT_EQ(info.metadata().at("steps_done"), std::to_string(step - before));
    EXPECT_NE(status.error_message().find("which led to step " + std::to_string(step)), std::string::npos)
        << status.error_message();
    const std::optional<EarlyEnd> end = EarlyEndOf(Received(status));
    ASSERT_TRUE(end);
    EXPECT_EQ(end->step, step);
    EXPECT_EQ(info.metadata().at("created_ids"), "1:" + std::to_string(end->created.at(1).packed()));
    v1::GetEntityRequest created;
    created.set_world(world);
    created.set_entity_id(end->created.at(1).packed());
    Must(server.simulation(), &Simulation::GetEntity, created);
    return;
  }
  FAIL() << "no reply came before its deadline";
}

TEST(LongStep, StopsWhenItsCallerIsGone) {
  TestServer server;
  const std::string world = MakePile(server);
  grpc::ClientContext context;
  auto call = std::async(std::launch::async, [&] {
    v1::StepResponse response;
    return server.simulation().Step(&context, ManySteps(world), &response);
  });
  WaitForStep(server, world, 3);

  context.TryCancel();

  EXPECT_EQ(call.get().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_LT(StepAtRest(server, world), kManySteps);
}

TEST(LongStep, EndsWithItsWorld) {
  TestServer server;
  const std::string world = MakePile(server);
  auto call =
      std::async(std::launch::async, [&] { return MustNot(server.simulation(), &Simulation::Step, ManySteps(world)); });
  WaitForStep(server, world, 3);
  v1::DeleteWorldRequest request;
  request.set_name(world);

  EXPECT_GE(Must(server.worlds(), &v1::WorldService::Stub::DeleteWorld, request).stamp().step(), 3u);

  ExpectRefusal(call.get(), Reason::kWorldNotFound, "world");
}

TEST(LongStep, LeavesTurnsToOtherWorldsOnTheSameThread) {
  TestServer server(ServerOptions{.workers = 1});
  const std::string busy = MakePile(server);
  const std::string other = server.CreateWorld().world().name();
  grpc::ClientContext context;
  auto call = std::async(std::launch::async, [&] {
    v1::StepResponse response;
    return server.simulation().Step(&context, ManySteps(busy), &response);
  });
  WaitForStep(server, busy, 1);

  EXPECT_EQ(server.Step(other, 50).stamp().step(), 50u);

  const uint64_t busy_step = StepOf(server, busy);
  EXPECT_LT(busy_step, kManySteps);
  context.TryCancel();
  EXPECT_EQ(call.get().error_code(), grpc::StatusCode::CANCELLED);
}

TEST(LongStep, IsWatchedWhileItRuns) {
  TestServer server(ServerOptions{.workers = 1});
  const std::string world = MakePile(server);
  grpc::ClientContext context;
  auto call = std::async(std::launch::async, [&] {
    v1::StepResponse response;
    return server.simulation().Step(&context, ManySteps(world), &response);
  });
  WaitForStep(server, world, 1);
  grpc::ClientContext view_context;
  view_context.set_deadline(std::chrono::system_clock::now() + kPatience);
  v1::WatchFramesRequest request;
  request.set_world(world);
  const auto reader = server.simulation().WatchFrames(&view_context, request);

  v1::WatchFramesResponse first, second;
  EXPECT_TRUE(reader->Read(&first));
  EXPECT_TRUE(reader->Read(&second));

  EXPECT_GT(second.frame().stamp().step(), first.frame().stamp().step());
  view_context.TryCancel();
  reader->Finish();
  context.TryCancel();
  call.get();
}

// Engines are made one after the other, which takes a minute.
v1::StepRequest ManyEngines(const std::string& world) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  request.set_request_id("once");
  for (int i = 0; i < 500; ++i) request.add_commands()->mutable_create_entity()->mutable_entity()->CopyFrom(Ball(i));
  for (int i = 0; i < 40'000; ++i) {
    request.add_commands()->mutable_set_engine()->set_engine(i % 2 == 0 ? "engines/bullet" : "engines/ode");
    request.add_commands()->mutable_set_gravity()->mutable_gravity()->set_z(-9);
  }
  return request;
}

int CountEntities(TestServer& server, const std::string& world) {
  v1::ListEntitiesRequest request;
  request.set_world(world);
  return Must(server.simulation(), &Simulation::ListEntities, request).entities_size();
}

TEST(LongBatch, StopsAfterItsDeadlineAndTellsWhichCommandsWereCarriedOut) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  const v1::StepRequest request = ManyEngines(world);
  const int before = CountEntities(server, world);
  // One that is over while commands are checked has no effect.
  for (auto time = std::chrono::milliseconds(500); CountEntities(server, world) == before; time *= 2) {
    ASSERT_LT(time, kPatience);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + time);
    v1::StepResponse response;
    ASSERT_EQ(server.simulation().Step(&context, request, &response).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  }
  // A retry hears how it ended; that the caller was gone the server may have heard before it looked at the time.
  const Status status = MustNot(server.simulation(), &Simulation::Step, request);
  const std::optional<EarlyEnd> end = EarlyEndOf(status);
  ASSERT_TRUE(end && end->commands_done) << status;
  EXPECT_LT(*end->commands_done, static_cast<uint32_t>(request.commands_size()));
  EXPECT_NE(status.message().find(std::to_string(*end->commands_done) + " of its commands"), std::string::npos);
}

// So many spheres in one place that one step takes seconds, within the bounds of what a world may use.
std::string MakeCrowd(TestServer& server) {
  const std::string world = server.CreateWorld().world().name();
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  for (int i = 0; i < 1300; ++i) request.add_commands()->mutable_create_entity()->mutable_entity()->CopyFrom(Ball(0));
  Must(server.simulation(), &Simulation::Step, request);
  return world;
}

// To make a tree of its triangles takes far longer than there is time for.
TEST(LongCommand, OfWhichNobodyHearsHasNoEffect) {
  constexpr uint32_t kPoints = 500'000;
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  v1::RigidBody& body = *request.add_commands()->mutable_create_entity()->mutable_entity()->mutable_rigid_body();
  body.set_motion_type(v1::MOTION_TYPE_STATIC);
  v1::TriangleMesh& soup = *body.add_geometries()->mutable_shape()->mutable_triangle_mesh();
  for (uint32_t i = 0; i < kPoints; ++i) {
    for (const double x : {std::sin(i), std::cos(7.0 * i), std::sin(13.0 * i)}) soup.add_vertices(x);
    for (uint32_t k = 0; k < 3; ++k) soup.add_indices((3 * i + k) * 2654435761u % kPoints);
  }
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(300));
  v1::StepResponse response;

  const grpc::Status status = server.simulation().Step(&context, request, &response);

  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  v1::ListEntitiesRequest list;
  list.set_world(world);
  const v1::ListEntitiesResponse left = Must(server.simulation(), &Simulation::ListEntities, list);
  EXPECT_EQ(left.entities_size(), 1) << "the ground alone";
}

TEST(LongStep, IsUndoneWithinItsFirstStepAfterItsDeadline) {
  TestServer server;
  const std::string world = MakeCrowd(server);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(20));
  v1::StepResponse response;
  EXPECT_EQ(server.simulation().Step(&context, ManySteps(world), &response).error_code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(StepAtRest(server, world), 0u);
}

TEST(LongStep, EndsWithinAStepWithItsWorld) {
  TestServer server;
  const std::string world = MakeCrowd(server);
  auto call =
      std::async(std::launch::async, [&] { return MustNot(server.simulation(), &Simulation::Step, ManySteps(world)); });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  v1::DeleteWorldRequest request;
  request.set_name(world);
  EXPECT_EQ(Must(server.worlds(), &v1::WorldService::Stub::DeleteWorld, request).stamp().step(), 0u);
  ExpectRefusal(call.get(), Reason::kWorldNotFound, "world");
}

TEST(LongStep, LeavesOtherWorldsTheirTurnWithinOneStep) {
  TestServer server(ServerOptions{.workers = 1});
  const std::string busy = MakeCrowd(server);
  const std::string other = server.CreateWorld().world().name();
  grpc::ClientContext context;
  auto call = std::async(std::launch::async, [&] {
    v1::StepResponse response;
    return server.simulation().Step(&context, ManySteps(busy), &response);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  v1::StepRequest request;
  request.set_world(other);
  request.add_commands()->mutable_set_gravity()->mutable_gravity()->set_z(-9);

  EXPECT_EQ(Must(server.simulation(), &Simulation::Step, request).stamp().step(), 1u);

  EXPECT_EQ(StepOf(server, busy), 0u) << "which is still in its first step";
  context.TryCancel();
  EXPECT_EQ(call.get().error_code(), grpc::StatusCode::CANCELLED);
}

TEST(Mailbox, RefusesWhatItCannotHold) {
  constexpr int kMoreThanItHolds = 300;
  TestServer server(ServerOptions{.workers = 1});
  const std::string world = MakePile(server);
  grpc::ClientContext long_context;
  auto call = std::async(std::launch::async, [&] {
    v1::StepResponse response;
    return server.simulation().Step(&long_context, ManySteps(world), &response);
  });
  WaitForStep(server, world, 1);

  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  struct Waiting {
    grpc::ClientContext context;
    v1::StepResponse response;
    std::promise<grpc::Status> status;
  };
  std::vector<std::unique_ptr<Waiting>> calls;
  for (int i = 0; i < kMoreThanItHolds; ++i) {
    Waiting& waiting = *calls.emplace_back(std::make_unique<Waiting>());
    waiting.context.set_deadline(std::chrono::system_clock::now() + kPatience);
    server.simulation().async()->Step(&waiting.context, &request, &waiting.response,
                                      [&waiting](grpc::Status status) { waiting.status.set_value(status); });
  }
  // The long call is over only when the last of these has come, so that none can be served meanwhile.
  int refused = 0;
  std::vector<std::future<grpc::Status>> answers;
  for (const auto& waiting : calls) answers.push_back(waiting->status.get_future());
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (refused < kMoreThanItHolds - 255 && std::chrono::steady_clock::now() < give_up) {
    refused = 0;
    for (const auto& answer : answers) refused += answer.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  long_context.TryCancel();
  call.get();

  int exhausted = 0, served = 0;
  for (auto& answer : answers) {
    const Status status = Received(answer.get());
    if (status.ok()) {
      ++served;
    } else {
      ExpectRefusal(status, Reason::kLimitExceeded, "");
      ++exhausted;
    }
  }
  EXPECT_EQ(served, 255);  // and the long one
  EXPECT_EQ(exhausted, kMoreThanItHolds - 255);
}

}  // namespace
}  // namespace genphys::testing

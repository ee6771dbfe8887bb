#include "genphys/client/client.h"

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <functional>
#include <future>
#include <mutex>
#include <thread>
#include <vector>

#include "genphys/v1/simulation_service.grpc.pb.h"
#include "genphys/v1/world_service.grpc.pb.h"
#include "genphys/wire/encode.h"
#include "genphys/wire/encode_frame.h"
#include "genphys/wire/error.h"

namespace genphys::client {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): there is no other way to write 1s

grpc::Status Refused(const Status& status) {
  return {static_cast<grpc::StatusCode>(status.code()), MessageOf(status), EncodeStatus(status).SerializeAsString()};
}

/// A server that answers as a test tells it: what the client makes of answers is tested here, not the answers.
class ScriptedServer {
 public:
  class Worlds : public v1::WorldService::Service {
   public:
    grpc::Status CreateWorld(grpc::ServerContext*, const v1::CreateWorldRequest* request,
                             v1::CreateWorldResponse* response) override {
      *response->mutable_world() = request->world();
      return grpc::Status::OK;
    }
    grpc::Status DeleteWorld(grpc::ServerContext*, const v1::DeleteWorldRequest* request,
                             v1::DeleteWorldResponse*) override {
      const std::lock_guard lock(mutex_);
      deleted_.push_back(request->name());
      return grpc::Status::OK;
    }
    std::vector<std::string> deleted() {
      const std::lock_guard lock(mutex_);
      return deleted_;
    }

   private:
    std::mutex mutex_;
    std::vector<std::string> deleted_;
  };

  class Simulation : public v1::SimulationService::Service {
   public:
    std::function<grpc::Status(grpc::ServerContext*, const v1::StepRequest&, v1::StepResponse*)> step;
    std::function<grpc::Status(grpc::ServerContext*, const v1::WatchEventsRequest&,
                               grpc::ServerWriter<v1::WatchEventsResponse>*)>
        watch;

    grpc::Status Step(grpc::ServerContext* context, const v1::StepRequest* request,
                      v1::StepResponse* response) override {
      return step(context, *request, response);
    }
    grpc::Status WatchEvents(grpc::ServerContext* context, const v1::WatchEventsRequest* request,
                             grpc::ServerWriter<v1::WatchEventsResponse>* writer) override {
      return watch(context, *request, writer);
    }
  };

  ScriptedServer() {
    address_ = "unix:" + testing::TempDir() + "client_test_" + std::to_string(getpid()) + ".sock";
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address_, grpc::InsecureServerCredentials());
    builder.RegisterService(&worlds);
    builder.RegisterService(&simulation);
    server_ = builder.BuildAndStart();
  }
  ~ScriptedServer() { server_->Shutdown(std::chrono::system_clock::now()); }

  World MakeWorld(const WorldOptions& options = {.name = "w"}, const ConnectOptions& connect = {}) {
    return *Connect(address_, connect)->CreateWorld(options);
  }

  Worlds worlds;
  Simulation simulation;

 private:
  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

v1::WatchEventsResponse Slept(uint64_t epoch, uint64_t sequence) {
  v1::WatchEventsResponse response;
  response.mutable_stamp()->set_epoch(epoch);
  response.mutable_batch()->set_first_sequence(sequence);
  response.mutable_batch()->set_last_sequence(sequence);
  EncodeEvent({sequence, 1, EntitySlept{EntityId(0, 1)}}, response.mutable_batch()->add_events());
  return response;
}

v1::WatchEventsResponse Bookmark(uint64_t epoch, uint64_t last_sequence) {
  v1::WatchEventsResponse response;
  response.mutable_stamp()->set_epoch(epoch);
  response.mutable_batch()->set_first_sequence(last_sequence + 1);
  response.mutable_batch()->set_last_sequence(last_sequence);
  return response;
}

void WaitUntilCancelled(grpc::ServerContext* context) {
  while (!context->IsCancelled()) std::this_thread::sleep_for(1ms);
}

TEST(Client, SaysWhereNoServerAnswers) {
  const Result<Server> server = Connect("unix:/nonexistent/genphys.sock", {.connect_timeout = 50ms});

  EXPECT_EQ(server.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_NE(MessageOf(server.status()).find("/nonexistent/genphys.sock"), std::string::npos);
}

TEST(Client, RestoresTheRefusalOfTheServer) {
  ScriptedServer server;
  server.simulation.step = [](auto*, auto&, auto*) {
    return Refused(Refuse(Reason::kOutOfRange, "commands[0].set_gravity.gravity.x", "too much"));
  };
  World world = server.MakeWorld();

  const Status status = world.SetGravity({1e9, 0, 0});

  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(MessageOf(status), "too much");
  ASSERT_TRUE(RefusalOf(status).has_value());
  EXPECT_EQ(RefusalOf(status)->reason, Reason::kOutOfRange);
  EXPECT_EQ(RefusalOf(status)->field, "commands[0].set_gravity.gravity.x");
}

TEST(Client, GivesEveryCallADeadline) {
  constexpr auto kOnTheWay = 5s;  // a deadline travels as the time that is left, rounded up
  ScriptedServer server;
  std::chrono::system_clock::duration left{};
  server.simulation.step = [&](grpc::ServerContext* context, auto&, auto*) {
    left = context->deadline() - std::chrono::system_clock::now();
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();

  ASSERT_TRUE(world.Step().ok());
  EXPECT_LE(left, kDefaultDeadline + kOnTheWay);
  EXPECT_GE(left, kDefaultDeadline - kOnTheWay);

  ASSERT_TRUE(world.Step(1, {.deadline = 100s}).ok());
  EXPECT_GE(left, 100s - kOnTheWay);
  EXPECT_LE(left, 100s + kOnTheWay);
}

TEST(Client, DoesNotWaitBeyondTheDeadline) {
  ScriptedServer server;
  server.simulation.step = [](grpc::ServerContext* context, auto&, auto*) {
    WaitUntilCancelled(context);
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();

  EXPECT_EQ(world.Step(1, {.deadline = 50ms}).status().code(), absl::StatusCode::kDeadlineExceeded);
}

TEST(Client, TriesAgainUnderTheSameRequestId) {
  ScriptedServer server;
  std::vector<std::string> ids;
  server.simulation.step = [&](auto*, const v1::StepRequest& request, auto*) {
    ids.push_back(request.request_id());
    return ids.size() == 1 ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "not now") : grpc::Status::OK;
  };
  World world = server.MakeWorld();

  ASSERT_TRUE(world.Step().ok());
  ASSERT_TRUE(world.Step().ok());

  ASSERT_EQ(ids.size(), 3u);
  EXPECT_FALSE(ids[0].empty());
  EXPECT_EQ(ids[1], ids[0]);
  EXPECT_NE(ids[2], ids[1]);
}

TEST(Client, SendsWhatAStepWasAskedToDo) {
  ScriptedServer server;
  v1::StepRequest received;
  server.simulation.step = [&](auto*, const v1::StepRequest& request, v1::StepResponse* response) {
    received = request;
    response->mutable_stamp()->set_step(7);
    response->add_results()->set_created_id(EntityId(3, 1).packed());
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();

  const Result<StepResult> result = world.Step(5, {.commands = {CreateEntity{}},
                                                   .step_size = 0.125,
                                                   .frame = FrameOptions{.poses = false, .net_forces = true},
                                                   .events = std::nullopt,
                                                   .stats = true,
                                                   .expected_step = 2});

  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->stamp.step, 7u);
  EXPECT_EQ(result->created, std::vector<CreatedId>{EntityId(3, 1)});
  EXPECT_EQ(received.world(), "worlds/w");
  EXPECT_EQ(received.steps(), 5u);
  EXPECT_TRUE(received.commands(0).has_create_entity());
  EXPECT_EQ(received.step_size_seconds(), 0.125);
  EXPECT_FALSE(received.frame().poses());
  EXPECT_TRUE(received.frame().velocities() && received.frame().net_forces() && received.stats());
  EXPECT_FALSE(received.has_events());
  EXPECT_EQ(received.expected_step(), 2u);
}

TEST(Client, DeletesTheWorldThatItMadeWithItsHandle) {
  ScriptedServer server;
  {
    World world = server.MakeWorld({.name = "a"});
    const World moved = std::move(world);
    EXPECT_TRUE(server.worlds.deleted().empty());
  }
  EXPECT_EQ(server.worlds.deleted(), std::vector<std::string>{"worlds/a"});
}

TEST(Client, KeepsTheWorldThatItIsToldToKeep) {
  ScriptedServer server;
  { server.MakeWorld({.name = "a", .keep = true}); }
  { server.MakeWorld({.name = "b"}).Keep(); }

  EXPECT_TRUE(server.worlds.deleted().empty());
}

TEST(Client, RefusesAnEventThatItCannotRead) {
  ScriptedServer server;
  server.simulation.step = [](auto*, auto&, v1::StepResponse* response) {
    response->mutable_events()->add_events()->set_sequence(1);
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();

  EXPECT_EQ(world.Step().status().code(), absl::StatusCode::kInternal);
}

TEST(EventStream, GoesOnWhereTheConnectionBroke) {
  ScriptedServer server;
  std::vector<v1::WatchEventsRequest> requests;
  server.simulation.watch = [&](grpc::ServerContext* context, const v1::WatchEventsRequest& request, auto* writer) {
    requests.push_back(request);
    if (requests.size() == 1) {
      writer->Write(Bookmark(77, 4));
      writer->Write(Slept(77, 5));
      return grpc::Status(grpc::StatusCode::UNAVAILABLE, "gone");
    }
    writer->Write(Slept(77, 6));
    WaitUntilCancelled(context);
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();
  EventStream events = *world.WatchEvents();
  EXPECT_EQ(events.position().sequence, 4u);

  for (const uint64_t expected : {5u, 6u}) {
    const Result<std::optional<EventBatch>> batch = events.Next();
    ASSERT_TRUE(batch.ok() && *batch) << batch.status();
    ASSERT_EQ((*batch)->events.size(), 1u);
    EXPECT_EQ((*batch)->events[0].sequence, expected);
  }

  ASSERT_EQ(requests.size(), 2u);
  EXPECT_FALSE(requests[0].has_epoch() || requests[0].has_after_sequence());
  EXPECT_EQ(requests[1].epoch(), 77u);
  EXPECT_EQ(requests[1].after_sequence(), 5u);
}

TEST(EventStream, TellsWhatWasLost) {
  ScriptedServer server;
  server.simulation.watch = [](grpc::ServerContext*, const v1::WatchEventsRequest& request, auto* writer) {
    EXPECT_EQ(request.after_sequence(), 2u);
    v1::WatchEventsResponse gap;
    gap.mutable_stamp()->set_epoch(request.epoch());
    gap.mutable_gap()->set_first_sequence(3);
    gap.mutable_gap()->set_last_sequence(9);
    writer->Write(gap);
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();
  EventStream events = *world.WatchEvents({.after = StreamPosition{.epoch = 1, .sequence = 2}});

  const Result<std::optional<EventBatch>> batch = events.Next();

  ASSERT_TRUE(batch.ok() && *batch) << batch.status();
  ASSERT_TRUE((*batch)->gap.has_value());
  EXPECT_EQ((*batch)->gap->first_sequence, 3u);
  EXPECT_EQ((*batch)->gap->last_sequence, 9u);
  EXPECT_EQ(events.position().sequence, 9u);
  EXPECT_EQ(*events.Next(), std::nullopt);
}

TEST(EventStream, LivesOnAfterATimeout) {
  ScriptedServer server;
  std::promise<void> timed_out;
  server.simulation.watch = [&](grpc::ServerContext*, auto&, auto* writer) {
    writer->Write(Bookmark(1, 0));
    timed_out.get_future().wait();
    writer->Write(Slept(1, 1));
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();
  EventStream events = *world.WatchEvents();

  EXPECT_EQ(events.Next(20ms).status().code(), absl::StatusCode::kDeadlineExceeded);
  timed_out.set_value();

  const Result<std::optional<EventBatch>> batch = events.Next();
  ASSERT_TRUE(batch.ok() && *batch) << batch.status();
  EXPECT_EQ((*batch)->last_sequence, 1u);
}

TEST(EventStream, EndsWhenAnotherThreadCancelsIt) {
  ScriptedServer server;
  server.simulation.watch = [](grpc::ServerContext* context, auto&, auto* writer) {
    writer->Write(Bookmark(1, 0));
    WaitUntilCancelled(context);
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();
  EventStream events = *world.WatchEvents();
  std::future<Result<std::optional<EventBatch>>> next = std::async(std::launch::async, [&] { return events.Next(); });

  EXPECT_EQ(next.wait_for(20ms), std::future_status::timeout);
  events.Cancel();

  EXPECT_EQ(*next.get(), std::nullopt);
  EXPECT_EQ(*events.Next(), std::nullopt);
}

TEST(EventStream, CanBeDroppedWithMessagesUnread) {
  ScriptedServer server;
  server.simulation.watch = [](grpc::ServerContext* context, auto&, auto* writer) {
    for (uint64_t i = 1; i < 100; ++i) writer->Write(Slept(1, i));
    WaitUntilCancelled(context);
    return grpc::Status::OK;
  };
  World world = server.MakeWorld();

  for (int round = 0; round < 20; ++round) {
    const Result<EventStream> events = world.WatchEvents();
    ASSERT_TRUE(events.ok()) << events.status();
    EXPECT_EQ(events->position().sequence, 1u);
  }
}

TEST(EventStream, GivesTheRefusalOfTheServer) {
  ScriptedServer server;
  server.simulation.watch = [](grpc::ServerContext*, auto&, auto*) {
    return Refused(Refuse(Reason::kWorldNotFound, "world", "there is none"));
  };
  World world = server.MakeWorld();

  const Status status = world.WatchEvents().status();

  ASSERT_TRUE(RefusalOf(status).has_value()) << status;
  EXPECT_EQ(RefusalOf(status)->reason, Reason::kWorldNotFound);
}

std::shared_ptr<v1::Frame> FrameOf(uint32_t rows) {
  StateArrays state;
  state.Resize(rows);
  for (uint32_t row = 0; row < rows; ++row) {
    state.ids[row] = EntityId(2 * row, 1);
    state.positions.col(row) = Vector3(row, 10 + row, 20 + row);
    state.orientations.col(row) = Column4(1, 0, 0, 0);
  }
  if (rows > 1) state.asleep[1] = 1;
  v1::FrameRequest request;
  request.set_poses(true);
  auto frame = std::make_shared<v1::Frame>();
  const FrameEncoder encoder(state, request);
  std::string bytes(encoder.size(), '\0');
  encoder.Write(bytes.data());
  frame->ParseFromString(bytes);
  return frame;
}

TEST(ClientFrame, ShowsTheBytesOfTheMessageWhereTheyLie) {
  const std::shared_ptr<v1::Frame> message = FrameOf(3);

  const Result<Frame> frame = Frame::Make(message);

  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(static_cast<const void*>(frame->positions().data()), message->positions().data());
  EXPECT_EQ(frame->positions().col(2), Vector3(2, 12, 22));
  EXPECT_EQ(frame->pose(1).position, Vector3(1, 11, 21));
  EXPECT_TRUE(frame->pose(1).orientation.isApprox(Quaternion::Identity()));
  EXPECT_FALSE(frame->asleep(0));
  EXPECT_TRUE(frame->asleep(1));
  EXPECT_EQ(frame->linear_velocities().cols(), 0);
}

TEST(ClientFrame, OutlivesTheMessageItCameIn) {
  std::optional<Frame> frame = *Frame::Make(FrameOf(3));
  const Frame copy = *frame;
  frame.reset();

  EXPECT_EQ(copy.positions()(1, 2), 12);
  EXPECT_EQ(copy.ids().size(), 3u);
}

TEST(ClientFrame, FindsTheRowOfAnEntity) {
  const Frame frame = *Frame::Make(FrameOf(3));

  EXPECT_EQ(frame.row(EntityId(4, 1)), 2u);
  EXPECT_EQ(frame.row(EntityId(3, 1)), std::nullopt);
  EXPECT_EQ(frame.row(EntityId(4, 2)), std::nullopt);
  EXPECT_EQ(Frame().row(EntityId(4, 1)), std::nullopt);
}

TEST(ClientFrame, IsRefusedWhenAColumnHasAnotherNumberOfRows) {
  for (const uint32_t rows : {0u, 1u, 3u}) {
    const std::shared_ptr<v1::Frame> message = FrameOf(rows);
    EXPECT_TRUE(Frame::Make(message).ok()) << rows;
    message->mutable_positions()->push_back('\0');
    EXPECT_EQ(Frame::Make(message).status().code(), absl::StatusCode::kInternal) << rows;
  }
}

}  // namespace
}  // namespace genphys::client

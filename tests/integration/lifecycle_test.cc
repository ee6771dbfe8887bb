// The program genphysd: how it starts, says where it is, refuses to start, and stops.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <thread>

#include "genphys/wire/early_end.h"
#include "genphys/wire/error.h"
#include "support/test_server.h"

namespace genphys::testing {
namespace {

constexpr char kGreeting[] = "genphysd listening on ";
// What the program promises, and what a loaded machine may add to it.
constexpr std::chrono::seconds kStopMax{5};
constexpr std::chrono::seconds kAllowance{5};

// The address in the line with which a server that started greets; empty if it did not.
std::string AddressOf(ServerProcess& process) {
  const std::string line = process.ReadLine();
  return line.starts_with(kGreeting) ? line.substr(sizeof(kGreeting) - 1) : "";
}

TEST(Genphysd, SaysWhereItListensOncePerAddress) {
  TemporaryFolder folder;
  const std::string socket = "unix:" + (folder.path() / "s").string();
  ServerProcess process({"--listen", "127.0.0.1:0", "--listen", socket});

  const std::string tcp = AddressOf(process);
  const std::string unix_socket = AddressOf(process);

  EXPECT_TRUE(tcp.starts_with("127.0.0.1:")) << process.ReadErrors();
  EXPECT_NE(tcp, "127.0.0.1:0");
  EXPECT_EQ(unix_socket, socket);
  for (const std::string& address : {tcp, unix_socket}) {
    const auto stub = v1::WorldService::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
    Must(*stub, &v1::WorldService::Stub::CreateWorld, v1::CreateWorldRequest());
  }
  process.Signal(SIGTERM);
  EXPECT_EQ(process.Wait(), 0);
}

TEST(Genphysd, NamesTheWayOutWhenAPortIsTaken) {
  ServerProcess first({"--listen", "127.0.0.1:0"});
  const std::string address = AddressOf(first);
  ASSERT_FALSE(address.empty());

  ServerProcess second({"--listen", address});

  EXPECT_EQ(second.ReadLine(), "");
  EXPECT_NE(second.Wait(), 0);
  EXPECT_NE(second.ReadErrors().find("cannot listen at " + address), std::string::npos) << second.ReadErrors();
  EXPECT_NE(second.ReadErrors().find("--listen 127.0.0.1:0"), std::string::npos) << second.ReadErrors();
}

TEST(Genphysd, LeavesTheSocketOfALivingServerAlone) {
  TemporaryFolder folder;
  const std::string socket = "unix:" + (folder.path() / "s").string();
  ServerProcess first({"--listen", socket});
  ASSERT_EQ(AddressOf(first), socket);

  ServerProcess second({"--listen", socket});

  EXPECT_NE(second.Wait(), 0);
  const auto stub = v1::WorldService::NewStub(grpc::CreateChannel(socket, grpc::InsecureChannelCredentials()));
  Must(*stub, &v1::WorldService::Stub::CreateWorld, v1::CreateWorldRequest());
}

TEST(Genphysd, RefusesWhatItWasNotBuiltForAndAddressesOfOthers) {
  struct Case {
    std::vector<std::string> arguments;
    std::string said;
  };
  for (const Case& refused :
       {Case{{"--isolate", "world"}, "not built yet"}, Case{{"--isolate", "sometimes"}, "none, shard or world"},
        Case{{"--listen", "0.0.0.0:0"}, "--insecure-any-address"}, Case{{"--listen", "localhost"}, "host:port"},
        Case{{"--listen", "127.0.0.1:70000"}, "host:port"},
        Case{{"--listen", "unix:/nowhere/at/all/s"}, "there is no folder /nowhere/at/all"},
        Case{{"--workers", "abc"}, "no whole number from 0 to 1024"},
        Case{{"--workers", "-1"}, "is not from 0 to 1024"},
        Case{{"--default-engine", "perpetuum"}, "this server has: "}, Case{{"--colour", "red"}, "--colour"}}) {
    ServerProcess process(refused.arguments);
    EXPECT_EQ(process.ReadLine(), "");
    EXPECT_NE(process.Wait(), 0);
    EXPECT_NE(process.ReadErrors().find(refused.said), std::string::npos) << process.ReadErrors();
  }
  ServerProcess asked_for({"--listen", "0.0.0.0:0", "--insecure-any-address", "--isolate", "none"});
  EXPECT_NE(AddressOf(asked_for), "");
}

TEST(Genphysd, ExplainsItself) {
  ServerProcess help({"--help"});
  std::string text;
  for (std::string line = help.ReadLine(); !line.empty() || text.empty(); line = help.ReadLine()) text += line + "\n";
  EXPECT_EQ(help.Wait(), 0);
  EXPECT_NE(text.find("genphysd"), std::string::npos);
  ServerProcess version({"--version"});
  EXPECT_TRUE(version.ReadLine().starts_with("genphysd 0."));
  EXPECT_EQ(version.Wait(), 0);
}

TEST(Genphysd, EndsWithItsParentWhenAsked) {
  ServerProcess process({"--listen", "127.0.0.1:0", "--exit-with-parent"});
  ASSERT_NE(AddressOf(process), "");

  process.CloseInput();

  EXPECT_EQ(process.Wait(), 0);
}

// Else whoever sends them fills the log.
TEST(Genphysd, LogsNothingOfBytesThatItRefuses) {
  ServerProcess process({"--listen", "127.0.0.1:0", "--log-level", "warning"});
  {
    const auto channel = grpc::CreateChannel(AddressOf(process), grpc::InsecureChannelCredentials());
    for (const std::string bytes : {"\x0a\x0a\x0a\x08worlds/\xff", "\x12\x02\xff\xfe", "\x0a\x04\x0a\x7f"}) {
      std::string reply;
      const grpc::Status status = CallRaw(channel, "/genphys.v1.WorldService/CreateWorld", bytes, &reply);
      EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    }
  }

  process.Signal(SIGTERM);

  EXPECT_EQ(process.Wait(), 0);
  EXPECT_EQ(process.ReadErrors(), "");
}

TEST(Genphysd, EndsStreamsAndLongCallsOnASignalAndExitsWellInTime) {
  ServerProcess process({"--listen", "127.0.0.1:0"});
  const auto channel = grpc::CreateChannel(AddressOf(process), grpc::InsecureChannelCredentials());
  const auto worlds = v1::WorldService::NewStub(channel);
  const auto simulation = v1::SimulationService::NewStub(channel);
  const std::string world =
      Must(*worlds, &v1::WorldService::Stub::CreateWorld, v1::CreateWorldRequest()).world().name();
  v1::PlayWorldRequest play;
  play.set_name(world);
  Must(*worlds, &v1::WorldService::Stub::PlayWorld, play);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  v1::WatchEventsRequest request;
  request.set_world(world);
  const auto reader = simulation->WatchEvents(&context, request);
  v1::WatchEventsResponse first;
  ASSERT_TRUE(reader->Read(&first));
  const auto begin = std::chrono::steady_clock::now();

  process.Signal(SIGTERM);

  v1::WatchEventsResponse more;
  while (reader->Read(&more)) {
  }
  ExpectRefusal(Received(reader->Finish()), Reason::kDraining, "");
  EXPECT_EQ(process.Wait(), 0);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kStopMax + kAllowance);
}

TEST(Health, IsToldForEachServiceAndForTheWhole) {
  constexpr char kServing[] = "\x08\x01";  // HealthCheckResponse{status: SERVING}
  TestServer server;
  for (const std::string service :
       {"", "genphys.v1.EngineService", "genphys.v1.WorldService", "genphys.v1.SimulationService"}) {
    std::string request, reply;
    if (!service.empty()) request = "\x0a" + std::string(1, static_cast<char>(service.size())) + service;
    EXPECT_TRUE(CallRaw(server.channel(), "/grpc.health.v1.Health/Check", request, &reply).ok()) << service;
    EXPECT_EQ(reply, kServing) << service;
  }
  std::string reply;
  const grpc::Status unknown = CallRaw(server.channel(), "/grpc.health.v1.Health/Check", "\x0a\x01x", &reply);
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST(Shutdown, LetsACallUnderWayEnd) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::StepRequest request;
  request.set_world(world);
  // Long enough to be under way when the server stops: every step has a hash.
  request.set_steps(50000);
  auto call = std::async(std::launch::async, [&] {
    v1::StepResponse response;
    const grpc::Status status = Call(server.simulation(), &v1::SimulationService::Stub::Step, request, &response);
    return std::pair(Received(status), response.stamp().step());
  });
  v1::GetWorldRequest get;
  get.set_name(world);
  while (Must(server.worlds(), &v1::WorldService::Stub::GetWorld, get).stamp().step() == 0) {
  }

  server.Stop(kPatience);

  const auto [status, step] = call.get();
  EXPECT_TRUE(status.ok()) << status.ToString();
  EXPECT_EQ(step, 50000u);
}

// Of a world of its own: a command, and more steps than anybody comes to the end of, for each takes a good part of a
// millisecond.
constexpr uint32_t kEndless = 100000;

v1::StepRequest EndlessSteps(TestServer& server) {
  constexpr int kBalls = 2000;
  v1::World wanted;
  wanted.set_record_state_hash(true);
  v1::StepRequest request;
  request.set_world(server.CreateWorld(wanted).world().name());
  request.set_steps(0);
  for (int i = 0; i < kBalls; ++i) {
    v1::Entity& ball = *request.add_commands()->mutable_create_entity()->mutable_entity();
    ball.mutable_pose()->mutable_position()->set_x(2 * i);
    ball.mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere();
    ball.mutable_rigid_body()->mutable_auto_disable()->set_enabled(false);
  }
  Must(server.simulation(), &v1::SimulationService::Stub::Step, request);
  request.clear_commands();
  request.add_commands()->mutable_create_entity()->mutable_entity();
  request.set_steps(kEndless);
  return request;
}

void AwaitFirstStep(TestServer& server, const std::string& world) {
  v1::GetWorldRequest get;
  get.set_name(world);
  while (Must(server.worlds(), &v1::WorldService::Stub::GetWorld, get).stamp().step() == 0) {
  }
}

void ExpectToldHowFarItCame(const Status& refusal) {
  ExpectRefusal(refusal, Reason::kDraining, "");
  const std::optional<EarlyEnd> end = EarlyEndOf(refusal);
  ASSERT_TRUE(end) << refusal;
  EXPECT_GT(end->steps_done, 0u);
  EXPECT_LT(end->steps_done, kEndless);
  EXPECT_EQ(end->created.size(), 1u);
}

TEST(Shutdown, TellsAStepThatTakesTooLongHowFarItCame) {
  TestServer server;
  const v1::StepRequest request = EndlessSteps(server);
  auto step = std::async(std::launch::async, [&] {
    ExpectToldHowFarItCame(MustNot(server.simulation(), &v1::SimulationService::Stub::Step, request));
  });
  AwaitFirstStep(server, request.world());

  server.Stop(std::chrono::milliseconds(100));

  step.get();
}

TEST(Shutdown, TellsADriveThatTakesTooLongHowFarItCame) {
  TestServer server;
  v1::DriveRequest request;
  *request.mutable_step() = EndlessSteps(server);
  grpc::ClientContext context;
  const auto stream = server.simulation().Drive(&context);
  ASSERT_TRUE(stream->Write(request));
  AwaitFirstStep(server, request.step().world());

  auto stopped = std::async(std::launch::async, [&] { server.Stop(std::chrono::milliseconds(100)); });

  v1::DriveResponse reply;
  ASSERT_TRUE(stream->Read(&reply));
  ExpectToldHowFarItCame(DecodeRefusal(reply.refusal()));
  EXPECT_FALSE(stream->Read(&reply));
  ExpectRefusal(Received(stream->Finish()), Reason::kDraining, "");
  stopped.get();
}

TEST(Shutdown, TellsStepsOfManyWorldsThatTakeTooLongHowFarTheyCame) {
  TestServer server;
  v1::StepWorldsRequest request;
  for (int i = 0; i < 2; ++i) *request.add_requests() = EndlessSteps(server);
  grpc::ClientContext context;
  const auto reader = server.simulation().StepWorlds(&context, request);
  for (const v1::StepRequest& each : request.requests()) AwaitFirstStep(server, each.world());

  auto stopped = std::async(std::launch::async, [&] { server.Stop(std::chrono::milliseconds(100)); });

  int told = 0;
  for (v1::StepWorldsResponse reply; reader->Read(&reply);) {
    for (const v1::StepWorldsResult& result : reply.results()) {
      ExpectToldHowFarItCame(DecodeRefusal(result.refusal()));
      ++told;
    }
  }
  EXPECT_EQ(told, 2);
  EXPECT_TRUE(reader->Finish().ok());
  stopped.get();
}

TEST(Shutdown, EndsAnEndlessCallAtAStepBoundary) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::PlayWorldRequest play;
  play.set_name(world);
  play.set_real_time_factor(0);
  Must(server.worlds(), &v1::WorldService::Stub::PlayWorld, play);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  v1::WatchFramesRequest request;
  request.set_world(world);
  const auto reader = server.simulation().WatchFrames(&context, request);
  v1::WatchFramesResponse frame;
  ASSERT_TRUE(reader->Read(&frame));

  auto stopped = std::async(std::launch::async, [&] { server.Stop(kPatience); });

  while (reader->Read(&frame)) {
  }
  ExpectRefusal(Received(reader->Finish()), Reason::kDraining, "");
  stopped.get();
}

}  // namespace
}  // namespace genphys::testing

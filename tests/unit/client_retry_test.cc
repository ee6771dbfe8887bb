// A call is repeated when the server was not there, and only if that cannot do anything twice.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>

#include "genphys/client/client.h"
#include "genphys/v1/engine_service.grpc.pb.h"
#include "genphys/v1/world_service.grpc.pb.h"

namespace genphys::client {
namespace {

/// Fails the first `failures` calls with `code`.
class Doorman {
 public:
  grpc::Status Answer() { return ++calls <= failures ? grpc::Status(code, "not now") : grpc::Status::OK; }
  // The server answers on threads of its own.
  std::atomic<int> calls = 0;
  std::atomic<int> failures = 0;
  std::atomic<grpc::StatusCode> code = grpc::StatusCode::UNAVAILABLE;
};

class Engines final : public v1::EngineService::Service {
 public:
  explicit Engines(Doorman& door) : door_(door) {}
  grpc::Status ListEngines(grpc::ServerContext*, const v1::ListEnginesRequest*, v1::ListEnginesResponse*) override {
    return door_.Answer();
  }

 private:
  Doorman& door_;
};

class Worlds final : public v1::WorldService::Service {
 public:
  explicit Worlds(Doorman& door) : door_(door) {}
  grpc::Status CreateWorld(grpc::ServerContext*, const v1::CreateWorldRequest*,
                           v1::CreateWorldResponse* response) override {
    response->mutable_world()->set_name("worlds/w");
    return grpc::Status::OK;
  }
  grpc::Status ResetWorld(grpc::ServerContext*, const v1::ResetWorldRequest*, v1::ResetWorldResponse*) override {
    return door_.Answer();
  }
  grpc::Status DeleteWorld(grpc::ServerContext*, const v1::DeleteWorldRequest*, v1::DeleteWorldResponse*) override {
    return grpc::Status::OK;
  }

 private:
  Doorman& door_;
};

class ClientRetry : public testing::Test {
 protected:
  ClientRetry() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&engines_);
    builder.RegisterService(&worlds_);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }

  Doorman door_;
  Engines engines_{door_};
  Worlds worlds_{door_};
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
};

TEST_F(ClientRetry, RepeatsAReadUntilTheServerIsThere) {
  const Result<Server> server = Connect(address_);
  ASSERT_TRUE(server.ok()) << server.status();
  door_.failures = 2;

  EXPECT_TRUE(server->ListEngines().ok());
  EXPECT_EQ(door_.calls, 3);
}

TEST_F(ClientRetry, GivesUpAfterTheFourthAttempt) {
  const Result<Server> server = Connect(address_);
  ASSERT_TRUE(server.ok()) << server.status();
  door_.failures = 100;

  EXPECT_EQ(server->ListEngines().status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(door_.calls, 4);
}

TEST_F(ClientRetry, DoesNotRepeatWhatWasRefused) {
  const Result<Server> server = Connect(address_);
  ASSERT_TRUE(server.ok()) << server.status();
  door_.failures = 1;
  door_.code = grpc::StatusCode::INVALID_ARGUMENT;

  EXPECT_EQ(server->ListEngines().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(door_.calls, 1);
}

TEST_F(ClientRetry, NeverResetsAWorldTwice) {
  const Result<Server> server = Connect(address_);
  ASSERT_TRUE(server.ok()) << server.status();
  Result<World> world = server->CreateWorld({});
  ASSERT_TRUE(world.ok()) << world.status();
  door_.failures = 1;

  EXPECT_EQ(world->Reset().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(door_.calls, 1);
}

TEST_F(ClientRetry, EndsWithTheDeadline) {
  ConnectOptions options;
  options.deadline = std::chrono::milliseconds(40);
  const Result<Server> server = Connect(address_, options);
  ASSERT_TRUE(server.ok()) << server.status();
  door_.failures = 100;

  EXPECT_EQ(server->ListEngines().status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(door_.calls, 1);  // the first pause would end after the deadline
}

}  // namespace
}  // namespace genphys::client

#pragma once
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "genphys/services/server.h"
#include "genphys/status.h"
#include "genphys/v1/engine_service.grpc.pb.h"
#include "genphys/v1/simulation_service.grpc.pb.h"
#include "genphys/v1/world_service.grpc.pb.h"
#include "support/sweep.h"

// A real server and plain stubs, for tests that look at what goes over the wire.
//
//   TestServer server;
//   const v1::CreateWorldResponse created = server.CreateWorld();
//   const auto stepped = Must(server.simulation(), &v1::SimulationService::Stub::Step, request);

namespace genphys::testing {

/// Only a server that hangs meets it, however slow the machine and what watches the code.
inline constexpr std::chrono::seconds kPatience{kSweepStride == 1 ? 60 : 600};

/// A folder that is gone with this object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A server with every engine of this build, in this process, at a socket of its own.
class TestServer {
 public:
  /// Addresses are filled in when there are none.
  explicit TestServer(ServerOptions options = {});
  /// Shuts the server down at once, if Stop() did not.
  ~TestServer();

  Server& server() { return *server_; }
  /// As a client takes it.
  const std::string& address() const { return server_->addresses().front(); }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }
  v1::EngineService::Stub& engines() { return *engines_; }
  v1::WorldService::Stub& worlds() { return *worlds_; }
  v1::SimulationService::Stub& simulation() { return *simulation_; }

  /// A world as asked for, or a failure of the test.
  v1::CreateWorldResponse CreateWorld(const v1::World& world = {});
  /// A ball of radius 0.5 m with its centre at height `z` on the z axis, or a failure of the test; its id.
  uint64_t AddBall(const std::string& world, double z);
  /// Takes `steps` steps, or fails the test.
  v1::StepResponse Step(const std::string& world, uint32_t steps = 1);

  void Stop(std::chrono::milliseconds grace) { server_->Shutdown(grace), stopped_ = true; }

 private:
  TemporaryFolder folder_;
  std::unique_ptr<Server> server_;
  bool stopped_ = false;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::EngineService::Stub> engines_;
  std::unique_ptr<v1::WorldService::Stub> worlds_;
  std::unique_ptr<v1::SimulationService::Stub> simulation_;
};

/// One unary call with a deadline. `Method` is a method of the stub, as &v1::WorldService::Stub::GetWorld.
template <typename Stub, typename Request, typename Response>
grpc::Status Call(Stub& stub, grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                  const Request& request, Response* response) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  return (stub.*method)(&context, request, response);
}

/// That, for a call that must succeed.
template <typename Stub, typename Request, typename Response>
Response Must(Stub& stub, grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
              const Request& request) {
  Response response;
  const grpc::Status status = Call(stub, method, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_code() << ": " << status.error_message();
  return response;
}

/// What a client learns from `status`.
Status Received(const grpc::Status& status);

/// A call that must be refused: the status that the client learns.
template <typename Stub, typename Request, typename Response>
Status MustNot(Stub& stub, grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
               const Request& request) {
  Response response;
  return Received(Call(stub, method, request, &response));
}

/// Fails the test unless `status` is a refusal for `reason`, with the code that belongs to it, that blames `field`.
void ExpectRefusal(const Status& status, Reason reason, const std::string& field);

/// One unary call of bytes, whatever they are. `method` as in "/genphys.v1.SimulationService/Step".
grpc::Status CallRaw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                     const std::string& request, std::string* response);

/// A genphysd of this build in a process of its own ($GENPHYS_SERVER).
class ServerProcess {
 public:
  explicit ServerProcess(std::vector<std::string> arguments);
  /// Kills it, if it still runs.
  ~ServerProcess();

  /// The next line of its standard output without the line's end; empty when there is no more.
  std::string ReadLine();
  /// All that it wrote on standard error, once it has ended.
  std::string ReadErrors() const;
  void CloseInput();
  void Signal(int signal) const;
  /// Waits for its end: the exit status, or -1 if it did not end by itself.
  int Wait();

 private:
  TemporaryFolder folder_;
  pid_t pid_ = -1;
  int input_ = -1;
  int output_ = -1;
};

}  // namespace genphys::testing

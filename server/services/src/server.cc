#include "genphys/services/server.h"

#include <grpcpp/ext/channelz_service_plugin.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <string_view>
#include <utility>

#include "engine_service.h"
#include "genphys/hosting/in_process_host.h"
#include "genphys/hosting/world_directory.h"
#include "listen_address.h"
#include "open_calls.h"
#include "simulation_service.h"
#include "world_service.h"

namespace genphys {
namespace {

constexpr int kMillisecond = 1;
constexpr int kSecond = 1000 * kMillisecond;
// A connection that says nothing for so long is asked whether it is still there, and ends if it does not answer.
constexpr int kKeepaliveTime = 30 * kSecond;
constexpr int kKeepaliveTimeout = 10 * kSecond;
// Clients may ask as often as this; one that asks more often is sent away.
constexpr int kClientPingPeriodMin = 5 * kSecond;
// Calls that are still under way at the end of the grace are told to end, and have so long to say how far they came.
constexpr std::chrono::milliseconds kLastWords(1000);
// Who watches the health of the server, or asks it what it is, may go on for ever, and has been told that it ends.
constexpr std::chrono::milliseconds kWatchersGrace(100);

void SetTransport(grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(Server::kRequestBytesMax);
  builder.SetMaxSendMessageSize(-1);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveTime);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeout);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kClientPingPeriodMin);
  // Two servers on one port would share its clients at random.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
}

void TurnOnIntrospection() {
  static std::once_flag once;
  std::call_once(once, [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    grpc::channelz::experimental::InitChannelzService();
  });
}

Result<std::string> DefaultEngine(const BackendRegistry& registry, const std::string& asked_for) {
  if (registry.backends().empty()) return absl::FailedPreconditionError("this server was built without any engine");
  if (asked_for.empty()) return registry.backends().front()->capabilities().engine();
  if (registry.Find(asked_for) != nullptr) return asked_for;
  std::string names;
  for (const auto& backend : registry.backends()) names += " " + backend->capabilities().engine();
  return absl::InvalidArgumentError("there is no engine \"" + asked_for + "\"; this server has:" + names);
}

}  // namespace

// In the order in which they need each other.
struct Server::Parts {
  Parts(BackendRegistry given_registry, const std::string& default_engine, const ServerOptions& options)
      : registry(std::move(given_registry)),
        pool(options.workers),
        directory(
            pool,
            [this, default_engine](const std::string& name, const v1::World& wanted) {
              return InProcessHost::Create(registry, pool, name, wanted, default_engine);
            },
            options.worlds_max),
        engine_service(registry),
        world_service(directory, calls),
        simulation_service(directory, calls) {}

  BackendRegistry registry;
  OpenCalls calls;
  WorkerPool pool;
  WorldDirectory directory;
  EngineService engine_service;
  WorldService world_service;
  SimulationService simulation_service;
  std::unique_ptr<grpc::Server> server;
};

Server::Server() = default;

Server::~Server() {
  if (parts_ != nullptr && parts_->server != nullptr) Shutdown(std::chrono::milliseconds(0));
}

Result<std::unique_ptr<Server>> Server::Start(BackendRegistry registry, const ServerOptions& options) {
  if (options.addresses.empty()) return absl::InvalidArgumentError("no address to listen at");
  for (const std::string& address : options.addresses) {
    GENPHYS_RETURN_IF_ERROR(CheckListenAddress(address, options.any_address));
  }
  const Result<std::string> default_engine = DefaultEngine(registry, options.default_engine);
  if (!default_engine.ok()) return default_engine.status();
  if (const Status status = registry.SelfTest(); !status.ok()) {
    return absl::FailedPreconditionError("an engine does not work as it must: " + MessageOf(status));
  }

  std::unique_ptr<Server> server(new Server);
  server->parts_ = std::make_unique<Parts>(std::move(registry), *default_engine, options);
  Parts& parts = *server->parts_;
  TurnOnIntrospection();
  grpc::ServerBuilder builder;
  SetTransport(builder);
  constexpr int kNotReached = -1;
  std::vector<int> ports(options.addresses.size(), kNotReached);
  for (size_t i = 0; i < ports.size(); ++i) {
    builder.AddListeningPort(options.addresses[i], grpc::InsecureServerCredentials(), &ports[i]);
  }
  builder.RegisterService(&parts.engine_service);
  builder.RegisterService(&parts.world_service);
  builder.RegisterService(&parts.simulation_service);
  parts.server = builder.BuildAndStart();
  for (size_t i = 0; i < ports.size(); ++i) {
    // It gives up at the first address that it cannot have.
    if (ports[i] == kNotReached) return CannotListen(options.addresses[i]);
    server->addresses_.push_back(WithPort(options.addresses[i], ports[i]));
  }
  if (parts.server == nullptr) return absl::InternalError("the gRPC server does not start");

  grpc::HealthCheckServiceInterface* const health = parts.server->GetHealthCheckService();
  for (const char* name : {v1::EngineService::service_full_name(), v1::WorldService::service_full_name(),
                           v1::SimulationService::service_full_name()}) {
    health->SetServingStatus(name, true);
  }
  return server;
}

void Server::Shutdown(std::chrono::milliseconds grace) {
  parts_->server->GetHealthCheckService()->Shutdown();
  parts_->directory.Drain();
  parts_->calls.AwaitEnd(std::chrono::steady_clock::now() + grace);
  // What gRPC cancels never hears how far it came.
  parts_->directory.EndCalls();
  parts_->calls.AwaitEnd(std::chrono::steady_clock::now() + kLastWords);
  parts_->server->Shutdown(std::chrono::system_clock::now() +
                           std::min<std::chrono::nanoseconds>(grace, kWatchersGrace));
  parts_->server.reset();
}

}  // namespace genphys

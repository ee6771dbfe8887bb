#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "genphys/capabilities.h"
#include "genphys/client/options.h"
#include "genphys/client/world.h"
#include "genphys/status.h"

namespace genphys::client {

/// A physics engine of a server.
struct EngineInfo {
  std::string engine;  // short name, as in "ode"
  std::string version;
  std::vector<Feature> features;  // ascending
};

/// What one of many worlds shall do.
struct WorldSteps {
  std::string world;  // as World::name() tells it
  uint32_t steps = 1;
  StepOptions options;  // without a deadline: all have that of the call
};

/// A connection to one server; copies share it. Safe to use from several threads. Worlds keep it open.
class Server {
 public:
  /// A new world, deleted when its handle goes unless `options.keep`.
  Result<World> CreateWorld(const WorldOptions& options = {}) const;
  /// A world that exists, as "demo" or "worlds/demo"; never deleted by its handle. WORLD_NOT_FOUND if there is none.
  Result<World> OpenWorld(const std::string& name) const;
  /// Names as in "worlds/demo", in order.
  Result<std::vector<std::string>> ListWorlds() const;
  /// In order of name.
  Result<std::vector<EngineInfo>> ListEngines() const;

  /// Steps many worlds in one call, in parallel on the server. Result i is what World::Step() would say of `wanted[i]`;
  /// those that did not come because the call ended early have its status. Not tried again.
  std::vector<Result<StepResult>> StepWorlds(std::span<const WorldSteps> wanted,
                                             std::optional<std::chrono::milliseconds> deadline = std::nullopt) const;

 private:
  friend Result<Server> Connect(const std::string& address, const ConnectOptions& options);
  explicit Server(std::shared_ptr<Connection> connection);

  std::shared_ptr<Connection> connection_;
};

/// Connects to the server at "host:port" or "unix:path". UNAVAILABLE if none answers within options.connect_timeout.
Result<Server> Connect(const std::string& address, const ConnectOptions& options = {});

}  // namespace genphys::client

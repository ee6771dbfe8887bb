#pragma once
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "genphys/registry.h"
#include "genphys/status.h"

namespace genphys {

struct ServerOptions {
  /// "host:port" (port 0: a free one) or "unix:path"; one at least.
  std::vector<std::string> addresses;
  /// Without it only this machine's own addresses are listened at: whoever reaches the server may do everything.
  bool any_address = false;
  /// Threads that simulate; zero: one per processor.
  unsigned workers = 0;
  /// Short name; empty: the registry's first.
  std::string default_engine;
  size_t worlds_max = 1024;
};

/// The whole server in this process: worlds, services, and the gRPC server that listens. Health (for each service and
/// as a whole), reflection and channelz are on.
class Server {
 public:
  /// Largest request. Replies have no bound of the server's.
  static constexpr int kRequestBytesMax = 64 << 20;

  /// Tests the engines and listens. The error says what is in the way and what to do about it.
  static Result<std::unique_ptr<Server>> Start(BackendRegistry registry, const ServerOptions& options);
  /// Cancels what is under way.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Where it is reached, with the ports that were chosen.
  const std::vector<std::string>& addresses() const { return addresses_; }

  /// Stops: not healthy any more, new calls are refused, streams end with UNAVAILABLE, calls under way may go on for
  /// `grace` and then end as at a deadline, saying how far they came, if they can within a second. Returns when all
  /// have ended.
  void Shutdown(std::chrono::milliseconds grace);

 private:
  struct Parts;
  Server();

  std::vector<std::string> addresses_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace genphys

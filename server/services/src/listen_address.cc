#include "listen_address.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string_view>

namespace genphys {
namespace {

constexpr std::string_view kUnix = "unix:";

bool IsLoopback(std::string_view host) {
  return host == "localhost" || host == "[::1]" ||
         (host.starts_with("127.") && host.find_first_not_of("0123456789.") == host.npos);
}

bool SomebodyAnswers(const sockaddr_un& where) {
  const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return false;
  const bool answered = connect(probe, reinterpret_cast<const sockaddr*>(&where), sizeof(where)) == 0;
  close(probe);
  return answered;
}

Status CheckSocketPath(std::string_view path) {
  sockaddr_un where{};
  where.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof(where.sun_path)) {
    return absl::InvalidArgumentError("the path of a unix socket has 1 to " +
                                      std::to_string(sizeof(where.sun_path) - 1) + " bytes");
  }
  path.copy(where.sun_path, path.size());
  // gRPC would remove the socket of a living server and take its place.
  if (SomebodyAnswers(where)) return CannotListen(std::string(kUnix) + std::string(path));
  return absl::OkStatus();
}

bool IsPort(std::string_view text) {
  constexpr size_t kDigitsMax = 5;
  return !text.empty() && text.size() <= kDigitsMax && text.find_first_not_of("0123456789") == text.npos &&
         std::stoi(std::string(text)) <= UINT16_MAX;
}

}  // namespace

Status CheckListenAddress(const std::string& address, bool any_address) {
  if (address.starts_with(kUnix)) return CheckSocketPath(std::string_view(address).substr(kUnix.size()));
  const size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || !IsPort(std::string_view(address).substr(colon + 1))) {
    return absl::InvalidArgumentError("\"" + address +
                                      "\" is no address: write host:port, as in 127.0.0.1:50051, or "
                                      "unix:path");
  }
  if (!any_address && !IsLoopback(std::string_view(address).substr(0, colon))) {
    return absl::InvalidArgumentError(
        "\"" + address +
        "\" can be reached from other machines, and whoever reaches the server may do everything. "
        "Listen at 127.0.0.1, or add --insecure-any-address if that is what you want");
  }
  return absl::OkStatus();
}

std::string WithPort(const std::string& address, int port) {
  if (address.starts_with(kUnix)) return address;
  return address.substr(0, address.rfind(':') + 1) + std::to_string(port);
}

Status CannotListen(const std::string& address) {
  const bool is_path = address.starts_with(kUnix);
  if (is_path) {
    const std::filesystem::path folder = std::filesystem::path(address.substr(kUnix.size())).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !std::filesystem::is_directory(folder, ignored)) {
      return absl::NotFoundError("cannot listen at " + address + ": there is no folder " + folder.string() +
                                 ". Make it first, or choose another one");
    }
  }
  return absl::AlreadyExistsError("cannot listen at " + address + ": " +
                                  (is_path
                                       ? "another server does, or the folder cannot be written to. Choose another path"
                                       : "something else does, or the address is not this machine's. Choose another "
                                         "port, or port 0 for a free one") +
                                  ", as in --listen " + (is_path ? address + "2" : WithPort(address, 0)));
}

}  // namespace genphys

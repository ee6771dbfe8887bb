#include "server_process.h"

#include <stdexcept>
#include <string_view>

namespace genphys::bench {

ServerProcess::ServerProcess(const std::string& program)
    : process_({program, "--listen", "127.0.0.1:0", "--exit-with-parent", "--log-level", "warning"}) {
  constexpr std::string_view kGreeting = "genphysd listening on ";
  const std::string line = process_.ReadLine();
  if (!line.starts_with(kGreeting)) throw std::runtime_error("the server says \"" + line + '"');
  address_ = line.substr(kGreeting.size());
}

}  // namespace genphys::bench

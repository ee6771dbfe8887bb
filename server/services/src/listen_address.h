#pragma once
#include <string>

#include "genphys/status.h"

namespace genphys {

/// OK if the server may listen at `address`: of the form "host:port" or "unix:path", on this machine unless
/// `any_address`, and, for a path, without a living server there already.
Status CheckListenAddress(const std::string& address, bool any_address);

/// `address` with its port replaced by the one that was chosen.
std::string WithPort(const std::string& address, int port);

/// Why `address` cannot be listened at although it is a good one, and the way out.
Status CannotListen(const std::string& address);

}  // namespace genphys

#pragma once
#include <memory>

#include "genphys/backend.h"

namespace genphys {

/// Flight and nothing else: bodies pass through each other, and shapes only tell how mass is distributed. The smallest
/// example of a backend, to copy from.
std::unique_ptr<Backend> MakeBallisticBackend();

}  // namespace genphys

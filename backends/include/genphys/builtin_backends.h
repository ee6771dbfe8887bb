#pragma once

#include "genphys/registry.h"

namespace genphys {

/// A registry of every engine that this build was configured with, the default engine first.
BackendRegistry BuiltinBackends();

}  // namespace genphys

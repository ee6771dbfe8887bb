#pragma once
#include <string>

#include "contenders/scene.h"

namespace genphys::bench {

/// `scene` in one line, as world.py describes it. What it has no words for is a std::runtime_error.
std::string ToJson(const Scene& scene);

/// In full: read back, it is the same number.
std::string Exact(double number);

}  // namespace genphys::bench

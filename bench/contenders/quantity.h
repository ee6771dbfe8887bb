#pragma once
#include <string>
#include <vector>

namespace genphys::bench {

/// Something that a run came to.
struct Quantity {
  std::string name;
  double value = 0;
};

}  // namespace genphys::bench

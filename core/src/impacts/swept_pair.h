#pragma once
#include "genphys/contact.h"

namespace genphys {

/// A pair that one body flew into, maybe out of again, since the substep began.
struct SweptPair {
  EntityRow entity_a{};  // as in a ContactPair
  EntityRow entity_b{};
  GeometryRow geometry_a{};
  GeometryRow geometry_b{};
  double time = 0;       // s before the end of the substep
  double closing = 0;    // m/s, then
  bool is_deep = false;  // they had touched before, and it rolled into the other one
};

}  // namespace genphys

#pragma once
#include <vector>

#include "genphys/event.h"

namespace genphys {

/// Sorts what one step has to tell by kind, then by the ids concerned: the order depends on no engine and no thread.
void SortCanonically(std::vector<EventKind>& events);

}  // namespace genphys

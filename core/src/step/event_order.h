#pragma once
#include <span>
#include <vector>

#include "genphys/event.h"

namespace genphys {

/// Sorts what one step or one batch of commands has to tell by kind, then by the ids concerned: the order depends on no
/// engine and no thread.
void SortCanonically(std::vector<EventKind>& events);
/// The same of events that have their numbers, which stay where they are.
void SortCanonically(std::span<Event> events);

}  // namespace genphys

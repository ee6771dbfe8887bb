#include "step/event_order.h"

#include <algorithm>
#include <tuple>

namespace genphys {
namespace {

auto KeyOf(const EventKind& event) { return std::tuple(event.index(), EntitiesOf(event)); }

}  // namespace

void SortCanonically(std::vector<EventKind>& events) {
  std::stable_sort(events.begin(), events.end(),
                   [](const EventKind& a, const EventKind& b) { return KeyOf(a) < KeyOf(b); });
}

void SortCanonically(std::span<Event> events) {
  if (events.size() < 2) return;
  uint64_t sequence = events.front().sequence;
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return KeyOf(a.kind) < KeyOf(b.kind); });
  for (Event& event : events) event.sequence = sequence++;
}

}  // namespace genphys

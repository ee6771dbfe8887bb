#include "step/event_order.h"

#include <algorithm>
#include <tuple>

namespace genphys {
namespace {

struct IdsOf {
  template <typename Contact>
  requires requires(const Contact& contact) { contact.pair; }
  EntityPair operator()(const Contact& contact) const { return contact.pair; }
  template <typename Sensor>
  requires requires(const Sensor& sensor) { sensor.visitor; }
  EntityPair operator()(const Sensor& sensor) const { return {sensor.sensor, sensor.visitor}; }
  template <typename Single>
  requires requires(const Single& single) { single.id; }
  EntityPair operator()(const Single& single) const { return {single.id, {}}; }
};

auto KeyOf(const EventKind& event) { return std::tuple(event.index(), std::visit(IdsOf{}, event)); }

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

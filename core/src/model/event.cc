#include "genphys/event.h"

namespace genphys {
namespace {

struct Entities {
  template <typename OfTwo>
  requires requires(const OfTwo& event) { event.pair; }
  EntityPair operator()(const OfTwo& event) const { return event.pair; }
  template <typename OfSensor>
  requires requires(const OfSensor& event) { event.visitor; }
  EntityPair operator()(const OfSensor& event) const { return {event.sensor, event.visitor}; }
  template <typename OfOne>
  requires requires(const OfOne& event) { event.id; }
  EntityPair operator()(const OfOne& event) const { return {event.id, {}}; }
};

}  // namespace

EntityPair EntitiesOf(const EventKind& kind) { return std::visit(Entities{}, kind); }

}  // namespace genphys

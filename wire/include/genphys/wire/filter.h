#pragma once
#include <vector>

#include "genphys/event.h"
#include "genphys/ids.h"
#include "genphys/v1/event.pb.h"

namespace genphys {

/// Which events a subscriber wants, ready to be asked many times. Immutable, so it may be shared between threads.
class EventFilter {
 public:
  /// Everything that the world records.
  EventFilter() = default;
  explicit EventFilter(const v1::EventFilter& filter);

  /// Whether the subscriber wants `event`. Costs a search in the sorted ids.
  bool Matches(const Event& event) const;
  /// Whether contacts are to be sent with their points; see EncodeEvent().
  bool contact_points() const { return kinds_.contact_points; }

 private:
  bool Wants(const EventKind& kind) const;
  bool Names(EntityId id) const;

  EventKinds kinds_{.persisting_contacts = true, .moving = true};
  std::vector<EntityId> ids_;  // ascending; empty: all
};

}  // namespace genphys

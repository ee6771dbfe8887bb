#include "genphys/wire/filter.h"

#include <algorithm>
#include <variant>

#include "genphys/wire/decode.h"

namespace genphys {
namespace {

struct KindFlag {
  const EventKinds& kinds;

  bool operator()(const ContactBegan&) const { return kinds.contacts; }
  bool operator()(const ContactEnded&) const { return kinds.contacts; }
  bool operator()(const ContactPersisted&) const { return kinds.persisting_contacts; }
  bool operator()(const SensorEntered&) const { return kinds.sensors; }
  bool operator()(const SensorLeft&) const { return kinds.sensors; }
  bool operator()(const EntitySlept&) const { return kinds.sleeping; }
  bool operator()(const EntityWoke&) const { return kinds.sleeping; }
  bool operator()(const EntityStartedMoving&) const { return kinds.moving; }
  bool operator()(const EntityStoppedMoving&) const { return kinds.moving; }
  bool operator()(const EntityCreated&) const { return kinds.changes; }
  bool operator()(const EntityUpdated&) const { return kinds.changes; }
  bool operator()(const EntityDeleted&) const { return kinds.changes; }
  bool operator()(const EntityFaulted&) const { return kinds.changes; }
  bool operator()(const JointBroke&) const { return kinds.joints; }
  bool operator()(const JointCreated&) const { return kinds.changes; }
  bool operator()(const JointUpdated&) const { return kinds.changes; }
  bool operator()(const JointDeleted&) const { return kinds.changes; }
  bool operator()(const ForceFieldCreated&) const { return kinds.changes; }
  bool operator()(const ForceFieldUpdated&) const { return kinds.changes; }
  bool operator()(const ForceFieldDeleted&) const { return kinds.changes; }
};

}  // namespace

EventFilter::EventFilter(const v1::EventFilter& filter) {
  if (filter.has_kinds()) kinds_ = DecodeKinds(filter.kinds());
  ids_.reserve(static_cast<size_t>(filter.entity_ids_size()));
  for (const uint64_t id : filter.entity_ids()) ids_.push_back(EntityId::FromPacked(id));
  std::sort(ids_.begin(), ids_.end());
}

bool EventFilter::Wants(const EventKind& kind) const { return std::visit(KindFlag{kinds_}, kind); }

// The world has no id that a filter could name.
bool EventFilter::Names(EntityId id) const { return !id.is_null() && std::binary_search(ids_.begin(), ids_.end(), id); }

bool EventFilter::Matches(const Event& event) const {
  if (!Wants(event.kind)) return false;
  if (ids_.empty()) return true;
  const EntityPair named = EntitiesOf(event.kind);
  return Names(named.a) || Names(named.b);
}

}  // namespace genphys

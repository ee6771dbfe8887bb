#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "genphys/event.h"
#include "genphys/ids.h"

namespace genphys {

/// Two entities that touch, or a sensor and its visitor.
struct TouchingPair {
  EntityPair pair;
  bool is_sensor = false;
  bool a_is_sensor = false;  // which of the two carries the sensor
  auto operator<=>(const TouchingPair&) const = default;
};

/// Pairs that touch, which are found by either of the two: what somebody touches costs by how much that is, and not by
/// how many pairs there are, and so do coming and going. Each pair is in a list of either side, and every list is a
/// chain through one array: who is woken among very many reads a few places of memory, where a tree has them by dozens.
class PairSet {
 public:
  /// Unless it is there.
  void Insert(const TouchingPair& pair);
  /// If it is there.
  void Erase(const TouchingPair& pair);

  /// Calls visit(pair) for each of which `id` is one side, in no particular order. Nothing may be inserted or erased
  /// meanwhile.
  template <typename Visit>
  void VisitOf(EntityId id, Visit&& visit) const {
    if (id.index() >= lists_.size()) return;
    for (Place at = lists_[id.index()].first; at != kNone; at = LinkIn(id.index(), at).after) {
      const TouchingPair& pair = entries_[at].pair;
      if (pair.pair.a == id || pair.pair.b == id) visit(pair);
    }
  }

  size_t size() const { return entries_.size() - free_.size(); }
  /// Ascending.
  std::vector<TouchingPair> Sorted() const;

 private:
  using Place = uint32_t;
  static constexpr Place kNone = std::numeric_limits<Place>::max();

  struct Link {
    Place before = kNone;
    Place after = kNone;
  };
  struct Entry {
    TouchingPair pair;
    Link links[2];  // in the lists of a and b
  };
  struct List {
    Place first = kNone;
    uint32_t size = 0;
  };

  // Which side of the pair there has that slot.
  int SideOf(uint32_t slot, Place at) const { return entries_[at].pair.pair.a.index() == slot ? 0 : 1; }
  const Link& LinkIn(uint32_t slot, Place at) const { return entries_[at].links[SideOf(slot, at)]; }
  Link& LinkIn(uint32_t slot, Place at) { return entries_[at].links[SideOf(slot, at)]; }
  Place Find(const TouchingPair& pair) const;
  void Chain(uint32_t slot, Place at);
  void Unchain(uint32_t slot, Place at);

  std::vector<Entry> entries_;
  std::vector<Place> free_;  // of entries_
  std::vector<List> lists_;  // by slot of an entity's id, whose generations share one
};

}  // namespace genphys

#pragma once
#include <cstddef>
#include <set>

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

/// Pairs that touch, ascending, which are found by either of the two: what somebody touches costs by how much that is,
/// and not by how many pairs there are.
class PairSet {
 public:
  void Insert(const TouchingPair& pair) {
    by_first_.insert(pair);
    by_second_.insert(pair);
  }
  void Erase(const TouchingPair& pair) {
    by_first_.erase(pair);
    by_second_.erase(pair);
  }

  /// Calls visit(pair) for each of which `id` is one side. Nothing may be inserted or erased meanwhile.
  template <typename Visit>
  void VisitOf(EntityId id, Visit&& visit) const {
    VisitRange(by_first_, id, visit);
    VisitRange(by_second_, id, visit);
  }

  size_t size() const { return by_first_.size(); }
  auto begin() const { return by_first_.begin(); }
  auto end() const { return by_first_.end(); }

 private:
  // By that side, and by the rest to tell pairs of the same one apart.
  template <EntityId EntityPair::*side>
  struct Before {
    using is_transparent = void;
    bool operator()(const TouchingPair& x, const TouchingPair& y) const {
      return x.pair.*side != y.pair.*side ? x.pair.*side < y.pair.*side : x < y;
    }
    bool operator()(const TouchingPair& x, EntityId id) const { return x.pair.*side < id; }
    bool operator()(EntityId id, const TouchingPair& x) const { return id < x.pair.*side; }
  };

  template <typename Set, typename Visit>
  static void VisitRange(const Set& set, EntityId id, Visit& visit) {
    const auto [first, last] = set.equal_range(id);
    for (auto pair = first; pair != last; ++pair) visit(*pair);
  }

  std::set<TouchingPair, Before<&EntityPair::a>> by_first_;
  std::set<TouchingPair, Before<&EntityPair::b>> by_second_;
};

}  // namespace genphys

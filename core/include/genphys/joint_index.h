#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "genphys/ids.h"
#include "genphys/joint.h"
#include "genphys/joint_row.h"

namespace genphys {

/// The row of one side of a joint.
inline EntityRow RowOf(const EntityRef& entity) {
  return entity.id.is_null() ? kWorldRow : EntityRow{entity.id.index()};
}

/// Which joints an entity has, so that nobody has to look through those of all others. It follows from the scene.
class JointIndex {
 public:
  /// Slots of its joints' ids, ascending; until the next change.
  std::span<const uint32_t> Of(EntityRow row) const {
    return Index(row) < slots_.size() ? slots_[Index(row)] : std::span<const uint32_t>();
  }

  void Add(uint32_t slot, const JointDesc& joint) {
    for (const EntityRow row : {RowOf(joint.entity_a), RowOf(joint.entity_b)}) {
      if (row == kWorldRow) continue;
      if (Index(row) >= slots_.size()) slots_.resize(Index(row) + size_t{1});
      std::vector<uint32_t>& slots = slots_[Index(row)];
      slots.insert(std::lower_bound(slots.begin(), slots.end(), slot), slot);
    }
  }

  void Remove(uint32_t slot, const JointDesc& joint) {
    for (const EntityRow row : {RowOf(joint.entity_a), RowOf(joint.entity_b)}) {
      if (row != kWorldRow) std::erase(slots_[Index(row)], slot);
    }
  }

  void Clear() { slots_.clear(); }

 private:
  std::vector<std::vector<uint32_t>> slots_;  // by row
};

}  // namespace genphys

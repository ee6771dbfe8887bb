#include "frame_rows.h"

#include <algorithm>

namespace genphys {

FrameRows ChooseRows(const StateArrays& state, const v1::FrameRequest& request) {
  const std::vector<EntityId>& ids = state.ids;
  FrameRows chosen;
  if (request.entity_ids().empty()) {
    // As long as nobody was deleted, rows are in the order of ids, with room for more at the end.
    // Null comes before every id, so that this ends at the first hole.
    const auto end = std::is_sorted_until(ids.begin(), ids.end());
    const bool begins_with_hole = !ids.empty() && ids.front().is_null();
    if (!begins_with_hole && std::all_of(end, ids.end(), [](EntityId id) { return id.is_null(); })) {
      chosen.count = static_cast<size_t>(end - ids.begin());
      return chosen;
    }
    for (uint32_t row = 0; row < ids.size(); ++row) {
      if (!ids[row].is_null()) chosen.rows.push_back(row);
    }
  } else {
    for (const uint64_t packed : request.entity_ids()) {
      const EntityId id = EntityId::FromPacked(packed);
      if (!id.is_null() && id.index() < ids.size() && ids[id.index()] == id) chosen.rows.push_back(id.index());
    }
  }
  std::sort(chosen.rows.begin(), chosen.rows.end(), [&](uint32_t a, uint32_t b) { return ids[a] < ids[b]; });
  chosen.rows.erase(std::unique(chosen.rows.begin(), chosen.rows.end()), chosen.rows.end());
  chosen.count = chosen.rows.size();
  return chosen;
}

}  // namespace genphys

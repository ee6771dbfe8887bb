#include "frame_check.h"

#include <string>

namespace genphys {

Status CheckFrameEntities(const World& world, const v1::FrameRequest& wanted) {
  const std::vector<EntityId>& there = world.state().ids;
  for (int i = 0; i < wanted.entity_ids_size(); ++i) {
    const EntityId id = EntityId::FromPacked(wanted.entity_ids(i));
    if (id.index() < there.size() && there[id.index()] == id) continue;
    const Status status = world.CheckId(id, "frame.entity_ids[" + std::to_string(i) + "]");
    const std::optional<Refusal> refusal = RefusalOf(status);
    if (refusal && refusal->reason != Reason::kStaleId) return status;
  }
  return absl::OkStatus();
}

}  // namespace genphys

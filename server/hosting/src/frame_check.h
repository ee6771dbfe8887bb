#pragma once
#include "genphys/status.h"
#include "genphys/v1/frame.pb.h"
#include "genphys/world.h"

namespace genphys {

/// MISSING_FIELD or ENTITY_NOT_FOUND "frame.entity_ids[i]" if one of the entities that `wanted` names never was. Of one
/// that is gone there is nothing to be told, as of one that goes later.
Status CheckFrameEntities(const World& world, const v1::FrameRequest& wanted);

}  // namespace genphys

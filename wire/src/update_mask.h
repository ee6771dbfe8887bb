#pragma once
#include <google/protobuf/field_mask.pb.h>

#include <string>

#include "genphys/command.h"
#include "genphys/status.h"
#include "genphys/v1/entity.pb.h"

namespace genphys {

/// The path of one of the paths of a command's mask.
std::string PlaceInMask(int index);

/// The parts of an entity that `mask` names. INVALID_VALUE for a path that names no part which can change by itself.
Result<EntityFields> DecodeMask(const google::protobuf::FieldMask& mask);

/// The parts that `entity` sets: what an absent mask means. A rigid body counts by its parts, so that what it leaves
/// unset stays; one that sets no part counts as a whole.
EntityFields PopulatedFields(const v1::Entity& entity);

/// The paths of `fields`.
void EncodeMask(EntityFields fields, google::protobuf::FieldMask* out);

}  // namespace genphys

#pragma once
#include "genphys/joint.h"
#include "genphys/status.h"

namespace genphys {

/// Refuses the first number that the model does not take, with the path of the field as the wire spells it. Entities
/// are the caller's to check.
Status CheckJoint(const JointDesc& joint);

/// How the wire spells the kind.
std::string_view NameOf(const JointKind& kind);

/// `current` with the named fields of `update`. INVALID_VALUE for a part of a kind that the joint is not.
Result<JointDesc> Merged(const JointDesc& current, const JointDesc& update, JointFields fields);

}  // namespace genphys

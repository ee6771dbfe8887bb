#pragma once
#include "genphys/joint.h"
#include "genphys/status.h"
#include "genphys/v1/command.pb.h"

namespace genphys {

/// The parts of a joint that the paths name. INVALID_VALUE for a path that names none, and for one of another kind
/// than the joint sets.
Result<JointFields> DecodeJointMask(const v1::Joint& joint, const google::protobuf::FieldMask& mask);

/// What an update without a mask changes: all that the joint sets, and of its kind all.
JointFields PopulatedFields(const v1::Joint& joint);

/// The paths of `fields` of a joint of this kind, in order.
void EncodeJointMask(const JointKind& kind, JointFields fields, google::protobuf::FieldMask* out);

}  // namespace genphys

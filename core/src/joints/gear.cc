#include "joints/kinds.h"

namespace genphys {

void WriteRows(const GearJoint& joint, RowWriter& writer) { writer.LockGear(joint.ratio); }

}  // namespace genphys

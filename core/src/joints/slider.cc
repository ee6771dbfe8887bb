#include "joints/kinds.h"

namespace genphys {

void WriteRows(const SliderJoint& joint, RowWriter& writer) {
  writer.LockAcross();
  writer.LockOrientation();
  writer.Drive(writer.Along(2), joint.axis);
}

}  // namespace genphys

#include "joints/kinds.h"

namespace genphys {

void WriteRows(const FixedJoint&, RowWriter& writer) {
  writer.LockPoint();
  writer.LockOrientation();
}

}  // namespace genphys

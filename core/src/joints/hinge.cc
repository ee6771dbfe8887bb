#include <cmath>

#include "joints/kinds.h"

namespace genphys {

void WriteRows(const HingeJoint& joint, RowWriter& writer) {
  writer.LockPoint();
  writer.LockTilt();
  const Quaternion turn = writer.Turn();
  writer.Drive({.place = 5, .axis = writer.a().axis(2), .position = 2 * std::atan2(turn.z(), turn.w())}, joint.axis);
}

}  // namespace genphys

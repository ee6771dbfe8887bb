#include "joints/kinds.h"

namespace genphys {

void WriteRows(const DistanceJoint& joint, RowWriter& writer) {
  const Vector3 apart = writer.b().frame.position - writer.a().frame.position;
  const double distance = apart.norm();
  const Vector3 axis = distance > 1e-9 ? Vector3(apart / distance) : writer.a().axis(0);
  writer.Drive({.place = 0, .axis = axis, .position = distance}, joint.axis);
}

}  // namespace genphys

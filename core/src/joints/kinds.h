#pragma once
#include "joints/row_writer.h"

namespace genphys {

// Each kind of joint says what it locks and what it leaves free.

void WriteRows(const BallJoint& joint, RowWriter& writer);
void WriteRows(const HingeJoint& joint, RowWriter& writer);
void WriteRows(const SliderJoint& joint, RowWriter& writer);
void WriteRows(const UniversalJoint& joint, RowWriter& writer);
void WriteRows(const FixedJoint& joint, RowWriter& writer);
void WriteRows(const WheelJoint& joint, RowWriter& writer);
void WriteRows(const SixDofJoint& joint, RowWriter& writer);
void WriteRows(const DistanceJoint& joint, RowWriter& writer);
void WriteRows(const GearJoint& joint, RowWriter& writer);

}  // namespace genphys

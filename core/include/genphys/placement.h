#pragma once
#include "genphys/math.h"

namespace genphys {

/// Where a frame is in another one, its axes as the columns of a matrix: a Pose for those who transform many points.
struct Placement {
  Vector3 position = Vector3::Zero();
  Matrix3 rotation = Matrix3::Identity();

  Vector3 Transform(const Vector3& local) const { return position + rotation * local; }
  Vector3 ToLocal(const Vector3& outer) const { return rotation.transpose() * (outer - position); }
  /// `inner`, given in the same frame as this, in this frame.
  Placement ToLocal(const Placement& inner) const {
    return {ToLocal(inner.position), rotation.transpose() * inner.rotation};
  }
};

inline Placement ToPlacement(const Pose& pose) { return {pose.position, pose.orientation.toRotationMatrix()}; }

}  // namespace genphys

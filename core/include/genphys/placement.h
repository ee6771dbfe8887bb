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

/// `inner`, given in the frame of `outer`, in that in which `outer` is.
inline Placement PlacedIn(const Placement& outer, const Pose& inner) {
  // As most geometries are in their entity.
  const bool is_parallel = inner.orientation.coeffs() == Quaternion::Identity().coeffs();
  return {outer.Transform(inner.position),
          is_parallel ? outer.rotation : Matrix3(outer.rotation * inner.orientation.toRotationMatrix())};
}

inline Placement ToPlacement(const Pose& pose) { return {pose.position, pose.orientation.toRotationMatrix()}; }

}  // namespace genphys

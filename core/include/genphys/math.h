#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace genphys {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
/// Unit quaternion. Text, wire and columns order it w x y z; Eigen's own coefficient order stays inside math.h.
using Quaternion = Eigen::Quaterniond;

/// Position and orientation of a frame, expressed in another one that the user of the pose names.
struct Pose {
  Vector3 position = Vector3::Zero();
  Quaternion orientation = Quaternion::Identity();

  /// The point `p`, given in this frame, in the frame that this pose is expressed in.
  Vector3 Transform(const Vector3& p) const { return position + orientation * p; }
  /// The pose `inner`, given in this frame, in the frame that this pose is expressed in.
  Pose Transform(const Pose& inner) const {
    return {Transform(inner.position), (orientation * inner.orientation).normalized()};
  }
};

inline bool operator==(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

using Column4 = Eigen::Vector4d;

/// A quaternion as a column: w x y z.
inline Column4 ToColumn(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
/// A column w x y z as a quaternion; not normalised.
inline Quaternion FromColumn(const Column4& c) { return {c[0], c[1], c[2], c[3]}; }

}  // namespace genphys

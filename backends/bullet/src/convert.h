#pragma once
#include <LinearMath/btTransform.h>

#include "genphys/math.h"

static_assert(sizeof(btScalar) == sizeof(double), "the float64 flavour of Bullet is needed");

namespace genphys::bullet_backend {

inline btVector3 ToBullet(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

inline btMatrix3x3 ToMatrix(const Matrix3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

inline Vector3 FromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// Where a frame is in the world, its axes as the columns of a matrix.
struct Placement {
  Vector3 position = Vector3::Zero();
  Matrix3 rotation = Matrix3::Identity();

  Vector3 Transform(const Vector3& local) const { return position + rotation * local; }
  Vector3 ToLocal(const Vector3& world) const { return rotation.transpose() * (world - position); }
  btTransform transform() const { return btTransform(ToMatrix(rotation), ToBullet(position)); }
};

inline Placement ToPlacement(const Pose& pose) { return {pose.position, pose.orientation.toRotationMatrix()}; }

}  // namespace genphys::bullet_backend

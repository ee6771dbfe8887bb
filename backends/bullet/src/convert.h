#pragma once
#include <LinearMath/btTransform.h>

#include "genphys/placement.h"

static_assert(sizeof(btScalar) == sizeof(double), "the float64 flavour of Bullet is needed");

namespace genphys::bullet_backend {

inline btVector3 ToBullet(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

inline btMatrix3x3 ToMatrix(const Matrix3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

inline Vector3 FromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

inline Matrix3 FromBullet(const btMatrix3x3& m) {
  Matrix3 matrix;
  for (int i = 0; i < 3; ++i) matrix.row(i) = FromBullet(m[i]);
  return matrix;
}

inline btTransform ToTransform(const Placement& placement) {
  return btTransform(ToMatrix(placement.rotation), ToBullet(placement.position));
}

}  // namespace genphys::bullet_backend

#pragma once
#include "genphys/inertia.h"
#include "genphys/math.h"

namespace genphys {

/// World tensor of a body: R I R^T.
Matrix3 WorldTensor(const Quaternion& orientation, const Matrix3& tensor);

/// `orientation` turned for `time` seconds by a constant angular velocity, exactly.
Quaternion Turned(const Quaternion& orientation, const Vector3& spin, double time);

/// The constant angular velocity (rad/s, world) that turns `orientation` in `time` seconds to where a free body with
/// the world angular momentum `momentum` (kg*m^2/s) and the inverse tensor `inverse_tensor` (axes of the body) goes.
/// The engine, which knows constant angular velocities only, is given this one and ends at the right orientation.
Vector3 MeanFreeSpin(const Quaternion& orientation, const Vector3& momentum, const Matrix3& inverse_tensor,
                     double time);

}  // namespace genphys

#pragma once
#include "genphys/inertia.h"
#include "genphys/math.h"

namespace genphys {

/// World tensor of a body: R I R^T, where `axes` is R.
Matrix3 WorldTensor(const Matrix3& axes, const Matrix3& tensor);
inline Matrix3 WorldTensor(const Quaternion& orientation, const Matrix3& tensor) {
  return WorldTensor(orientation.toRotationMatrix(), tensor);
}

/// `orientation` turned for `time` seconds by a constant angular velocity, exactly.
Quaternion Turned(const Quaternion& orientation, const Vector3& spin, double time);

/// The rotation vector that turns `before` into `after`, rad, world, the short way round.
Vector3 TurnBetween(const Quaternion& before, const Quaternion& after);
/// The one that is nearest to `expected`, which may be more than half a turn.
Vector3 TurnBetween(const Quaternion& before, const Quaternion& after, const Vector3& expected);

/// Bounds the work for a body at the limits of spin and step size.
constexpr int kInnerStepsMax = 4096;
/// Whether what turns by `spin` (rad/s) turns so often in `time` seconds that all inner steps there may be are too long
/// for how its axis goes: faster than worlds let anybody turn in any step.
bool IsBlurred(double spin, double time);

/// The constant angular velocity (rad/s, world) that turns `orientation` in `time` seconds to where a free body with
/// the world angular momentum `momentum` (kg*m^2/s) and the inverse tensor `inverse_tensor` (axes of the body) goes.
/// The engine, which knows constant angular velocities only, is given this one and ends at the right orientation.
/// Takes no more than `steps_max` inner steps, unless these were longer than half a radian: with too few for how fast
/// it turns, accuracy is lost, not stability. What is blurred goes on as it turns at first.
Vector3 MeanFreeSpin(const Quaternion& orientation, const Vector3& momentum, const Matrix3& inverse_tensor, double time,
                     int steps_max = kInnerStepsMax);
/// The same of a body whose `spin` (rad/s, world) at first is known.
Vector3 MeanFreeSpin(const Quaternion& orientation, const Vector3& spin, const Vector3& momentum,
                     const Matrix3& inverse_tensor, double time, int steps_max = kInnerStepsMax);

/// The same of a body that `torque` (N*m, world) turns all the time, whose momentum in the middle of it is `momentum`:
/// of fourth order.
Vector3 MeanDrivenSpin(const Quaternion& orientation, const Vector3& momentum, const Vector3& torque,
                       const Matrix3& inverse_tensor, double time);

/// Where a free body that is at `before` and turns by `spin_before` (rad/s, world) is after `time` seconds, and how it
/// turns then: with constant angular momentum, by the closed form of symmetric bodies, or by methods of fourth order in
/// steps of less than a radian.
struct FreeRotation {
  FreeRotation(const Quaternion& before, const Vector3& spin_before, const MassProperties& mass, double time);
  Quaternion orientation;
  Vector3 spin;  // rad/s, world
};

}  // namespace genphys

#pragma once
#include "genphys/math.h"

namespace genphys {

/// (rad per step)^2 of the fastest swing that is left alone. The leapfrog is stable below 4, and what is foretold of
/// the way of a joint takes a part of that.
inline constexpr double kResolvedSwing = 1;

/// The same, of which nothing of the way of a joint can be foretold any more.
inline constexpr double kUnforeseenSwing = 2;

/// How hard a force (N) that keeps its direction turns a body back when the body turns under it, N*m/rad: minus the
/// change of its torque, of which the symmetric part. `arm` (m) leads from the centre of mass to where it acts.
Matrix3 PullStiffness(const Vector3& arm, const Vector3& force);

/// The square of the fastest swing, (rad per step of `h` seconds)^2, or somewhat more.
double SwingOf(const Matrix3& inverse_tensor, const Matrix3& stiffness, double h);

/// By what to multiply the tensor of a body, at least one, so that steps resolve a swing (as SwingOf() gives it). A
/// light link between heavy ones swings faster than any step can follow, and the forces of joints, which a solve takes
/// as they are at the start of a step, would then drive it. All of the tensor grows alike, or torques about one axis
/// would turn the body about another. (Geometric stiffness: Andrews, Teichmann and Kry, Geometric stiffness for
/// real-time constrained multibody dynamics, Computer Graphics Forum 36, 2017.)
double InertiaFactor(double swing);

}  // namespace genphys

#include "motion/spring_forces.h"

namespace genphys {
namespace {

// Below this squared distance, m^2, a spring has no direction and pulls nowhere.
constexpr double kDirectionMin = 1e-24;

double InverseMassOf(const SpringEnd& end, const Vector3& axis) {
  const Vector3 turn = end.arm.cross(axis);
  return end.inverse_mass + turn.dot(end.inverse_tensor * turn);
}

Vector3 VelocityOf(const SpringEnd& end, double h, const RowValues<Wrench>& wrenches) {
  Vector3 linear = end.linear_velocity, angular = end.angular_velocity;
  if (end.moves) {
    const Wrench& wrench = wrenches[end.row];
    linear += h * (end.gravity + end.inverse_mass * wrench.force);
    angular += h * (end.inverse_tensor * wrench.torque);
  }
  return linear + angular.cross(end.arm);
}

void PushEnd(const SpringEnd& end, const Vector3& force, RowValues<Wrench>& wrenches) {
  if (!end.moves) return;
  wrenches[end.row].force += force;
  wrenches[end.row].torque += end.arm.cross(force);
}

}  // namespace

bool TiedPair::Prepare() {
  const Vector3 across = b.point - a.point;
  if (across.squaredNorm() < kDirectionMin) return false;
  length = across.norm();
  axis = across / length;
  inverse_mass = InverseMassOf(a, axis) + InverseMassOf(b, axis);
  return inverse_mass > 0;
}

double TiedPair::Speed(double h, const RowValues<Wrench>& wrenches) const {
  return axis.dot(VelocityOf(b, h, wrenches) - VelocityOf(a, h, wrenches));
}

// Where the step resolves the oscillation the stretch at the boundary pulls, in the middle of the time for which it
// does, which makes it the symplectic Euler method: the energy stays. The damper takes the velocity of then too
// (trapezoidal rule), or a later one where that much would turn it round, so that it leaves nothing of it instead.
// Otherwise backward Euler along the axis, which is stable for every stiffness, damping and step.
double TiedPair::Reach(double h) const {
  if (!IsResolved(h)) return h;
  const double damped = h * spring->damping * inverse_mass;
  return damped > 2 ? h - h / damped : h / 2;
}

double TiedPair::PullAt(double speed, double h) const {
  const bool is_resolved = IsResolved(h);
  const double stretch = length - spring->rest_length + (is_resolved ? 0 : h * speed);
  const double divisor =
      1 + Reach(h) * spring->damping * inverse_mass + (is_resolved ? 0 : h * h * spring->stiffness * inverse_mass);
  return (spring->stiffness * stretch + spring->damping * speed) / divisor;
}

bool TiedPair::IsResolved(double h) const { return h * h * spring->stiffness * inverse_mass < 1; }

void TiedPair::Push(double force, RowValues<Wrench>& wrenches) const {
  PushEnd(a, force * axis, wrenches);
  PushEnd(b, -force * axis, wrenches);
}

}  // namespace genphys

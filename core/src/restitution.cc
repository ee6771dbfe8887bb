#include "restitution.h"

#include <algorithm>
#include <cmath>

namespace genphys {
namespace {

constexpr int kSweepsMax = 50;
// m/s: the sweeps end once no bounce was changed by more.
constexpr double kSettled = 1e-9;

double InverseEffectiveMass(const MovingBody& body, const Vector3& arm, const Vector3& normal) {
  const Vector3 turn = arm.cross(normal);
  return body.inverse_mass + turn.dot(body.inverse_tensor * turn);
}

void Push(MovingBody& body, const Vector3& impulse, const Vector3& arm) {
  body.linear_velocity += body.inverse_mass * impulse;
  body.angular_velocity += body.inverse_tensor * arm.cross(impulse);
}

// Returns by how much (m/s) the speed of separation had to be changed.
double Settle(const Bounce& bounce, MovingBody& a, MovingBody& b) {
  const Vector3 arm_a = bounce.position - a.center;
  const Vector3 arm_b = bounce.position - b.center;
  const double softness = InverseEffectiveMass(a, arm_a, bounce.normal) + InverseEffectiveMass(b, arm_b, bounce.normal);
  if (!(softness > 0)) return 0;
  const double lacking = bounce.separation_speed - RelativeVelocity(a, b, bounce.position).dot(bounce.normal);
  // The contact may only push: less than nothing of the whole impulse is never left.
  const double impulse = std::max(lacking / softness, -*bounce.impulse);
  *bounce.impulse += impulse;
  Push(a, -impulse * bounce.normal, arm_a);
  Push(b, impulse * bounce.normal, arm_b);
  return std::abs(impulse * softness);
}

}  // namespace

Vector3 RelativeVelocity(const MovingBody& a, const MovingBody& b, const Vector3& point) {
  return b.linear_velocity + b.angular_velocity.cross(point - b.center) - a.linear_velocity -
         a.angular_velocity.cross(point - a.center);
}

void ApplyBounces(std::span<const Bounce> bounces, std::vector<MovingBody>& bodies) {
  for (int sweep = 0; sweep < kSweepsMax; ++sweep) {
    double largest = 0;
    for (const Bounce& bounce : bounces) {
      largest = std::max(largest, Settle(bounce, bodies[bounce.body_a], bodies[bounce.body_b]));
    }
    if (largest <= kSettled) return;
  }
}

}  // namespace genphys

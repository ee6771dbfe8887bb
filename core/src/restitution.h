#pragma once
#include <span>
#include <vector>

#include "genphys/contact.h"
#include "genphys/math.h"

namespace genphys {

/// Velocity and inverse inertia of a body, as the layer's own impulses need them. Immovable ones have zero inverses.
struct MovingBody {
  Vector3 center = Vector3::Zero();            // of mass, m, world
  Vector3 linear_velocity = Vector3::Zero();   // m/s
  Vector3 angular_velocity = Vector3::Zero();  // rad/s, world
  double inverse_mass = 0;
  Matrix3 inverse_tensor = Matrix3::Zero();  // world
};

/// Velocity of `b` against `a` at `point`, m/s, world.
Vector3 RelativeVelocity(const MovingBody& a, const MovingBody& b, const Vector3& point);

/// A contact that must separate.
struct Bounce {
  uint32_t body_a = 0;  // index of the bodies
  uint32_t body_b = 0;
  Vector3 position = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();  // from a to b
  double separation_speed = 0;        // m/s along the normal, to be reached: restitution times approach
  double* impulse = nullptr;          // N*s that acted along the normal already; what is added is added here
};

/// Adds normal impulses until the bodies separate as `bounces` ask (Newton's law of restitution), by projected
/// Gauss-Seidel. The engine itself solves contacts without restitution: engines differ there, and some lose it at
/// small steps.
void ApplyBounces(std::span<const Bounce> bounces, std::vector<MovingBody>& bodies);

}  // namespace genphys

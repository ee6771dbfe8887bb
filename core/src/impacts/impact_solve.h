#pragma once
#include <span>
#include <vector>

#include "genphys/math.h"
#include "impacts/ties.h"

namespace genphys {

/// Velocity and inverse inertia of a body that is hit. Immovable ones have zero inverses.
struct StruckBody {
  Vector3 center = Vector3::Zero();            // of mass, m, world
  Vector3 linear_velocity = Vector3::Zero();   // m/s
  Vector3 angular_velocity = Vector3::Zero();  // rad/s, world
  double inverse_mass = 0;
  Vector3 freedom = Vector3::Ones();         // zero along locked axes of the world
  Matrix3 tensor = Matrix3::Zero();          // world
  Matrix3 inverse_tensor = Matrix3::Zero();  // world

  Vector3 VelocityAt(const Vector3& point) const { return linear_velocity + angular_velocity.cross(point - center); }
  void Push(const Vector3& impulse, const Vector3& point) {
    linear_velocity += inverse_mass * freedom.cwiseProduct(impulse);
    angular_velocity += inverse_tensor * (point - center).cross(impulse);
  }
  /// The same, but nothing moves it.
  StruckBody Still() const {
    StruckBody still = *this;
    still.inverse_mass = 0;
    still.inverse_tensor.setZero();
    return still;
  }
};

/// Which of the two at a blow the other one bears, together with all that bears that.
enum class Borne : uint8_t { kUnknown, kA, kB };

/// A point where two bodies collide.
struct Blow {
  uint32_t body_a = 0;  // index of the bodies
  uint32_t body_b = 0;
  Vector3 position = Vector3::Zero();  // m, world
  Vector3 normal = Vector3::UnitZ();   // unit length, from a to b
  Vector3 run = Vector3::Zero();       // m/s across the normal: how the surface of b runs against that of a
  Borne borne = Borne::kUnknown;       // if known, no blow on who is borne comes later that bears somebody
  double friction = 0;
  double separation_speed = 0;        // m/s along the normal that is to be reached
  double impulse = 0;                 // N*s on b along the normal: the result
  Vector3 rubbing = Vector3::Zero();  // N*s on b across it: the result
};

/// Velocity of b against a at the blow, m/s.
Vector3 RelativeVelocity(const Blow& blow, std::span<const StruckBody> bodies);

/// Finds the impulses with which the bodies separate as the blows ask (Newton's law of restitution), each within
/// Coulomb's disc, by projected Gauss-Seidel, and applies them. What a blow has as impulses already stays part of them.
/// Whoever is tied to a body that is hit moves with it. Where blows say who is borne, none of them has impulses.
void SolveBlows(std::span<Blow> blows, std::span<StruckBody> bodies, Ties& ties);

/// The same of blows without impulses, which separate more slowly than they ask where those that hit each other would
/// have more kinetic energy than before: Newton's law at several points at once, with friction, can ask for more than
/// there is (Kane's paradox). What moves and cannot be moved may give energy to whom it hits.
void Restitute(std::span<Blow> blows, std::span<StruckBody> bodies, Ties& ties);

}  // namespace genphys

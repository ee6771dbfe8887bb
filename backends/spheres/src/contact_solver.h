#pragma once
#include <map>
#include <vector>

#include "genphys/contact.h"
#include "genphys/inertia.h"
#include "genphys/state.h"

namespace genphys::spheres_backend {

/// What a solve makes of one body.
struct Motion {
  Vector3 velocity = Vector3::Zero();  // m/s, of the centre of mass
  Vector3 spin = Vector3::Zero();      // rad/s
  // Move a body out of what it overlaps and are no part of its velocity.
  Vector3 push = Vector3::Zero();  // m/s
  Vector3 turn = Vector3::Zero();  // rad/s
};

/// Solves contacts by sweeps over all of them (projected Gauss-Seidel), each of which gives a contact the impulse that
/// it alone would need, within its bounds.
class ContactSolver {
 public:
  explicit ContactSolver(const StateArrays& state) : state_(state) {}

  /// Others than these weigh infinitely much.
  void AddMover(EntityRow row, const MassProperties& mass);
  /// `point` gets its impulses.
  void AddContact(const ContactPair& pair, ContactPoint& point);
  void Solve(double step_size, uint32_t sweeps);

  const Motion& MotionOf(EntityRow row) const { return bodies_.at(row).motion; }

 private:
  struct Body {
    Motion motion;
    Vector3 center = Vector3::Zero();
    double inverse_mass = 0;
    Matrix3 inverse_tensor = Matrix3::Zero();  // world
  };
  struct Contact {
    Body* a = nullptr;
    Body* b = nullptr;
    Vector3 arm_a, arm_b;
    MixedMaterial material;
    Vector3 rolling;  // rad/s, in the middle of the time that the solve is for
    Vector3 bend;     // m/s, by which it slips more on the mean of that time
    ContactPoint* point = nullptr;
    Vector3 torque = Vector3::Zero();  // N*m*s on b that resists rolling
    double spinning = 0;               // N*m*s on b about the normal
    double push = 0;                   // N*s that no velocity knows
  };

  Body& BodyAt(EntityRow row);
  static Vector3 SlipOf(const Contact& contact);
  static double Softness(const Contact& contact, const Vector3& axis);
  static double AngularSoftness(const Contact& contact, const Vector3& axis);
  static void Apply(const Contact& contact, const Vector3& impulse, const Vector3& torque);
  static void SweepNormal(Contact& contact, double step_size);
  static void SweepFriction(Contact& contact);
  static void SweepTorques(Contact& contact);
  static Vector3 ResistanceTo(const Vector3& rolling, const Contact& contact);
  static void SweepPush(Contact& contact, double step_size);

  const StateArrays& state_;
  std::map<EntityRow, Body> bodies_;  // whose places do not change as it grows
  std::vector<Contact> contacts_;
};

}  // namespace genphys::spheres_backend

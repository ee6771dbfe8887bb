#pragma once
#include <ode/ode.h>

#include <cstddef>

#include "exact_solver.h"

namespace genphys::ode_backend {

/// How deep a body may rest, m: with none at all the corners of a resting box lose touch and find it again at every
/// step, and the force on it flickers with them.
inline constexpr double kSurfaceLayer = 1e-6;
/// The part of an overlap that a step takes away.
inline constexpr double kErrorReduction = 0.2;
/// m/s^2, of the Earth.
inline constexpr double kGravity = 9.81;

/// m: ODE counts the rows of all axes about which a contact resists, also of those where it does so by nothing, but
/// then leaves them empty, and divides by what is in them.
inline constexpr double kLeastArm = 1e-30;

// What a contact tells ODE of the surfaces that meet there.

/// m/s, of what friction has to brake.
Vector3 SlipOf(const ContactConstraint& contact);

/// Friction against `slip`, which is `fast` (m/s) where friction does not stop it soon.
void SetFriction(const ContactConstraint& contact, const Vector3& slip, double fast, double step_size, dContact& to);

/// Turns the axes of friction to the rolling, which is `fast` (rad/s) where what resists does not stop it soon, unless
/// something slides.
void TurnToRolling(const ContactConstraint& contact, double fast, double step_size, dContact& to);

/// What is taken away of an overlap, and how fast.
void SetDepth(const ContactConstraint& contact, double step_size, dContact& to);

/// How much it gives way, in all directions, 1/kg times s: see dContactSoftCFM.
void SetSoftness(double softness, dContact& to);

/// Asks the solver to part by a speed that is of no account, and another one for each `number`. Before
/// SetOtherVelocity().
void Untie(size_t number, dContact& to);

/// Carries the body along with another side that moves by itself.
void SetOtherVelocity(const ContactConstraint& contact, dContact& to);

}  // namespace genphys::ode_backend

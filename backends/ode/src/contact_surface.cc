#include "contact_surface.h"

#include <algorithm>
#include <cmath>

#include "convert.h"

namespace genphys::ode_backend {
namespace {

// m/s: no overlap is taken away faster. What pushes bodies apart also leaves them with that speed, so that a ball
// without restitution would hop after every hard landing, and bodies created inside each other would be shot away.
constexpr double kPushOutSpeedMax = 0.3;
// Below the speed that this part of the Earth's gravity gives in one step, a direction of slip is noise, and following
// it keeps a resting body trembling.
constexpr double kSlipGate = 0.02 * kGravity;
// What slips in one step by less than friction stops in this part of it is held where it is rather than braked.
constexpr double kHeldPart = 0.8;
// m/s. Far more than what rounding makes of a speed; in a step of 1/60 s it is a way of 2e-12 m.
constexpr double kUntied = 1e-10;
// What its multiples have beyond whole numbers is spread evenly, however many there are (golden ratio).
constexpr double kGolden = 0.6180339887498949;
// rad/s^2: the same as the gate of a slip, of a direction of rolling.
constexpr double kRollGate = 0.2;

Vector3 Across(const Vector3& normal, const Vector3& v) { return v - normal * normal.dot(v); }

}  // namespace

Vector3 SlipOf(const ContactConstraint& contact) {
  return Across(contact.normal, contact.relative_velocity + contact.drawn);
}

// Friction is bounded along two axes. The first follows the slip, so that a slide is braked by the same force whatever
// way it goes; the engine's own axes would brake a diagonal one more.
// What slips much faster than friction could stop it soon is braked against its slip in the middle of the step, which
// is of second order, and has no friction across that: what holds it in one direction would be held in the other, too,
// and a push across it, however small, moves it.
void SetFriction(const ContactConstraint& contact, const Vector3& slip, double fast, double step_size, dContact& to) {
  to.surface.mu = contact.friction;
  const double sliding = contact.slip.norm();
  if (sliding > fast && Across(contact.normal, contact.relative_velocity).norm() > fast) {
    to.surface.mode |= dContactFDir1 | dContactAxisDep;
    ToOde(contact.slip / sliding, to.fdir1);
    to.surface.mu2 = 0;
    return;
  }
  const double speed = slip.norm();
  // However little pulls at a smooth or light body, that is no noise where it is about what friction bears there.
  const double pressed = std::abs(contact.relative_velocity.dot(contact.normal));
  const bool slips = pressed > 0 && speed > kHeldPart * contact.friction * pressed;
  if (speed > kSlipGate * step_size || slips) {
    to.surface.mode |= dContactFDir1;
    ToOde(slip / speed, to.fdir1);
  }
}

// Resistance to rolling is bounded along the same two axes. Where nothing slides the first follows the rolling. What
// rolls much faster than that could stop it soon is braked as what slides is, and not held across.
void TurnToRolling(const ContactConstraint& contact, double fast, double step_size, dContact& to) {
  to.surface.rho = to.surface.rho2 = std::max(contact.rolling_friction, kLeastArm);
  if (contact.rolling_friction == 0) return;
  const Vector3 way = contact.rolling.cross(contact.normal);
  const double rolling = way.norm();
  const bool slides = (to.surface.mode & dContactAxisDep) != 0;
  if (!slides && rolling > fast && Across(contact.normal, contact.relative_spin).norm() > fast) {
    to.surface.mode |= dContactFDir1;
    ToOde(way / rolling, to.fdir1);
    to.surface.rho = kLeastArm;
    return;
  }
  if ((to.surface.mode & dContactFDir1) != 0) return;
  const Vector3 along = contact.relative_spin.cross(contact.normal);
  const double spin = along.norm();
  if (spin <= kRollGate * step_size) return;
  to.surface.mode |= dContactFDir1;
  ToOde(along / spin, to.fdir1);
}

// No more of an overlap is told than may be taken away in one step.
void SetDepth(const ContactConstraint& contact, double step_size, dContact& to) {
  const ErrorCorrection& correction = contact.correction;
  const double part = correction.PartOf(step_size, kErrorReduction);
  const double most = correction.speed_max.value_or(kPushOutSpeedMax) * step_size / part;
  const double slop = correction.slop.value_or(0);
  to.geom.depth = std::min(std::max(contact.depth - slop, 0.0), kSurfaceLayer + most);
  if (!correction.time_constant) return;
  to.surface.mode |= dContactSoftERP;
  to.surface.soft_erp = part;
}

void SetSoftness(double softness, dContact& to) {
  to.surface.mode |= dContactSoftCFM | dContactSlip1 | dContactSlip2;
  to.surface.soft_cfm = to.surface.slip1 = to.surface.slip2 = softness;
}

// What rests or falls together has contacts that lack nothing at all, or all the same, so that some of them come to
// their bounds at the same time. The solver lets one go, finds that another one has no way left before it is at its
// own, takes that for an error, and gives up.
void Untie(size_t number, dContact& to) {
  const double turn = kGolden * static_cast<double>(number);
  to.surface.mode |= dContactMotionN;
  to.surface.motionN += kUntied * (turn - std::floor(turn));
}

// A constraint's target velocity says what the velocity of a second body would have.
void SetOtherVelocity(const ContactConstraint& contact, dContact& to) {
  if (contact.other_velocity.isZero(0)) return;
  to.surface.motionN += contact.normal.dot(contact.other_velocity);
  to.surface.mode |= dContactMotionN;
  if (contact.friction == 0) return;
  if ((to.surface.mode & dContactFDir1) == 0) {
    dVector3 unused;
    dPlaneSpace(to.geom.normal, to.fdir1, unused);
  }
  const Vector3 along = FromOde(to.fdir1);
  to.surface.motion1 = along.dot(contact.other_velocity);
  to.surface.motion2 = contact.normal.cross(along).dot(contact.other_velocity);
  to.surface.mode |= dContactFDir1 | dContactMotion1 | dContactMotion2;
}

}  // namespace genphys::ode_backend

#include "friction_lines.h"

#include <ode/ode.h>

#include <algorithm>

#include "convert.h"
#include "exact_solver.h"

namespace genphys::ode_backend {
namespace {

// As many as the layer's own solve takes, see DiscSolve.
constexpr size_t kSolvesMax = 13;
// m/s: friction that is no further from Coulomb's law is left.
constexpr double kAgreed = 1e-10;

Vector3 VelocityAt(dxBody* body, const Vector3& arm) {
  if (body == nullptr) return Vector3::Zero();
  return FromOde(dBodyGetLinearVel(body)) + FromOde(dBodyGetAngularVel(body)).cross(arm);
}

double InverseMass(dxBody* body) {
  if (body == nullptr) return 0;
  dMass mass;
  dBodyGetMass(body, &mass);
  return 1 / mass.mass;
}

// What slides on for some steps has one line.
bool HasOneLine(const dSurfaceParameters& surface) {
  return (surface.mode & dContactAxisDep) != 0 && surface.mu2 != surface.mu;
}

// What rolls on tells both lines.
bool RollsOn(const dSurfaceParameters& surface) {
  return (surface.mode & dContactRolling) != 0 && surface.rho != surface.rho2;
}

}  // namespace

void FrictionLines::Begin() {
  points_.clear();
  discs_.clear();
  best_.clear();
  next_ = solves_ = 0;
  least_ = std::numeric_limits<double>::infinity();
}

void FrictionLines::Turn(const ContactConstraint& contact, dxBody* body, dxBody* other, double softness,
                         double step_size, dContact& to) {
  if (solves_ == 0) {
    Point& added = points_.emplace_back();
    added.is_followed = to.surface.mu > 0 && !RollsOn(to.surface);
    if (!added.is_followed) return;
    added.body = body;
    added.other = other;
    added.softness = softness;
    Read(contact, to, added);
    return;
  }
  const size_t number = next_++;
  if (discs_.empty() || !points_[number].is_followed) return;
  const Point& point = points_[number];
  const FrictionDisc& disc = discs_[number];
  // The bound is told as a force: the solver takes what presses as it is without any friction.
  to.surface.mode &= ~dContactApprox1;
  to.surface.mu = disc.most() / step_size;
  if (point.is_line) return;
  ToOde(disc.along().x() * point.first + disc.along().y() * point.second, to.fdir1);
  to.surface.mode |= dContactFDir1 | dContactAxisDep;
  to.surface.mu2 = to.surface.mu;
  to.surface.slip2 += disc.softness() * step_size;
}

void FrictionLines::Read(const ContactConstraint& contact, const dContact& from, Point& to) {
  to.arm = contact.position - FromOde(dBodyGetPosition(to.body));
  if (to.other != nullptr) to.other_arm = contact.position - FromOde(dBodyGetPosition(to.other));
  to.run = contact.other_velocity;
  to.normal = contact.normal;
  if ((from.surface.mode & dContactFDir1) != 0) {
    to.first = FromOde(from.fdir1);
  } else {
    dVector3 first, second;
    dPlaneSpace(from.geom.normal, first, second);
    to.first = FromOde(first);
  }
  to.is_line = HasOneLine(from.surface);
  // Of one line nothing across it is looked at.
  if (!to.is_line) to.second = to.normal.cross(to.first);
  to.friction = contact.friction;
  to.mobility = InverseMass(to.body) + InverseMass(to.other);
}

Vector3 FrictionLines::SlipOf(const Point& point) {
  return VelocityAt(point.body, point.arm) - VelocityAt(point.other, point.other_arm) - point.run;
}

bool FrictionLines::Follow(std::span<const dJointFeedback> feedback, double step_size) {
  ++solves_;
  next_ = 0;
  // One that was not the best was done only to have that again.
  if (solves_ > kSolvesMax) return false;
  std::vector<FrictionDisc> turned = discs_;
  turned.resize(points_.size());
  double worst = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    if (!point.is_followed) continue;
    const auto along_lines = [&](const Vector3& v) -> Eigen::Vector2d {
      return {v.dot(point.first), v.dot(point.second)};
    };
    const Vector3 push = step_size * FromOde(feedback[i].f1);
    const Eigen::Vector2d impulse = along_lines(push);
    const Eigen::Vector2d slip = along_lines(SlipOf(point)) + point.softness * impulse;
    worst = std::max(worst, turned[i].Follow(impulse, slip, point.mobility, point.friction * push.dot(point.normal)));
  }
  const bool is_best = worst < least_;
  if (is_best) {
    least_ = worst;
    best_ = discs_;
  }
  if (worst <= kAgreed) return false;
  if (solves_ == kSolvesMax) {
    discs_ = best_;
    return !is_best;
  }
  discs_ = std::move(turned);
  return true;
}

bool FrictionLines::GoBack() {
  const bool has_been_solved = solves_ > 0 && solves_ <= kSolvesMax;
  solves_ = kSolvesMax + 1;
  next_ = 0;
  discs_ = best_;
  return has_been_solved;
}

}  // namespace genphys::ode_backend

// What contacts and joints come to before they are solved: the rows of the solver, what these start from, and along
// what friction works.
#include <algorithm>
#include <array>
#include <cmath>

#include "contacts/even_share.h"
#include "contacts/solver_rows.h"
#include "contacts/sweeps.h"

namespace genphys {
namespace {

// Of the slip that there would be without what friction did: with more than this part of it, the slip itself tells its
// direction.
constexpr double kKnownPart = 0.9;
// What is so many times as fast as friction slows it down in a step slides on for some steps.
constexpr double kSlides = 4;
// What slips no faster than this part of what friction gives in a step says nothing of where to.
constexpr double kNoDirection = 1e-6;
// rad/s: what turns more slowly has no direction.
constexpr double kNoSpin = 1e-9;

Vector3 VelocityAt(const SweptBody& body, const Vector3& place) {
  return body.linear_velocity + body.angular_velocity.cross(place - body.center);
}

}  // namespace

void ContactSweeps::Impl::WriteRows(bool direct) {
  changes_.clear();
  moves_.clear();
  for (const SweptBody& body : bodies_) changes_.push_back({.inverse_mass = body.inverse_mass});
  moves_ = changes_;
  for (const AddedRow& added : rows_) {
    BoundedRow& to = joints_.emplace_back();
    to.a = added.a;
    to.b = added.b;
    FillJointRow(*added.row, bodies_[to.a], bodies_[to.b], to);
  }
  for (const AddedPair& added : pairs_) {
    // What is in the way of a joint is pressed without bounds, and a little of that is much.
    if (!IsStuck(added.a, added.b)) ShareEvenly(added.points, added.impulses);
  }
  FindGoingOn();
  grips_.Find(pairs_, bodies_, direct, are_few_);
  for (size_t number = 0; number < pairs_.size(); ++number) {
    const AddedPair& added = pairs_[number];
    const Grip grip = grips_.Of(number);
    for (size_t i = 0; i < added.points.size(); ++i) {
      if (!added.points[i].is_ahead) AddPoint(added, i, grip, direct);
    }
  }
  AddTorsions();
}

void ContactSweeps::Impl::FindGoingOn() {
  going_on_.clear();
  goes_along_ = false;
  if (!are_few_) return;
  going_on_.resize(bodies_.size());
  // Impulses first.
  for (const AddedPair& added : pairs_) {
    const Vector3 &center_a = bodies_[added.a].center, &center_b = bodies_[added.b].center;
    MotionChange &a = going_on_[added.a], &b = going_on_[added.b];
    for (size_t i = 0; i < added.points.size(); ++i) {
      const ContactPoint& point = added.points[i];
      const PointImpulse& last = added.impulses[i];
      if (point.is_ahead) continue;
      goes_along_ = goes_along_ || GoesAlong(point, added.a, added.b);
      const Vector3 impulse = last.normal * point.normal + last.friction;
      a.linear.head<3>() -= impulse;
      b.linear.head<3>() += impulse;
      a.angular.head<3>() -= (point.position - center_a).cross(impulse) + last.torque;
      b.angular.head<3>() += (point.position - center_b).cross(impulse) + last.torque;
    }
  }
  for (size_t i = 0; i < going_on_.size(); ++i) {
    const SweptBody& body = bodies_[i];
    MotionChange& motion = going_on_[i];
    motion.linear = motion.linear * changes_[i].inverse_mass;
    motion.linear.head<3>() += body.linear_velocity;
    const Vector3 torque = motion.angular.head<3>();
    motion.angular.head<3>() = body.angular_velocity + body.inverse_tensor * torque;
  }
}

Vector3 ContactSweeps::Impl::SlipGoingOn(uint32_t a, uint32_t b, const Vector3& place) const {
  const auto velocity = [&](uint32_t id) -> Vector3 {
    const MotionChange& motion = going_on_[id];
    return motion.linear.head<3>() + motion.angular.head<3>().cross(place - bodies_[id].center);
  };
  return velocity(a) - velocity(b);
}

bool ContactSweeps::Impl::GoesAlong(const ContactPoint& point, uint32_t id_a, uint32_t id_b) const {
  const Vector3& normal = point.normal;
  const double least = kNoDirection * pull_ * point.friction * step_size_;
  const auto goes = [&](uint32_t id) {
    const Vector3 velocity = VelocityAt(bodies_[id], point.position);
    return (velocity - normal * normal.dot(velocity)).squaredNorm() > least * least;
  };
  return goes(id_a) || goes(id_b);
}

void ContactSweeps::Impl::AddPoint(const AddedPair& added, size_t number, const Grip& grip, bool direct) {
  const ContactPair& pair = *added.pair;
  ContactPoint& point = added.points[number];
  PointImpulse& impulse = added.impulses[number];
  const SweptBody &a = bodies_[added.a], &b = bodies_[added.b];
  const auto first_friction = static_cast<uint32_t>(frictions_.size());
  points_.push_back({&pair, &point, &impulse, first_friction, first_friction});
  // The points are those of the present poses: what was found for them is used in full. The solver then goes on over
  // many steps, and what rests comes to rest to the last digits.
  SolverRow& normal = normals_.emplace_back();
  normal.a = added.a;
  normal.b = added.b;
  const double rate = FillPush(-point.normal, point.position, a, b, normal);
  const double apart = FillContact(point, rate, pair.correction, step_size_, normal);
  if (apart > 0) pushes_.push_back({static_cast<uint32_t>(normals_.size()) - 1, apart, 0});
  StartFrom(impulse.normal, normal);
  AddFrictions(added, number, grip, direct);
}

void ContactSweeps::Impl::AddFrictions(const AddedPair& added, size_t number, const Grip& grip, bool direct) {
  const ContactPair& pair = *added.pair;
  const ContactPoint& point = added.points[number];
  const PointImpulse& impulse = added.impulses[number];
  const SolverRow& normal = normals_.back();
  const SweptBody &a = bodies_[added.a], &b = bodies_[added.b];
  const Vector3 &place = point.position, push = -point.normal;
  // Friction works against the slip of the surfaces, which may run over their bodies. Where a load comes through other
  // contacts, nothing slips before a solve that would tell its direction, but what friction did in the last one tells
  // it.
  const Vector3 run = pair.surface_velocity + pair.bend;
  const auto along_surface = [&](const Vector3& v) -> Vector3 { return v - push * push.dot(v); };
  const Vector3 slip = along_surface(VelocityAt(a, place) - VelocityAt(b, place) - run);
  const double ease = normal.mobility;
  const double inverse_mass = a.inverse_mass + b.inverse_mass;
  // How much slower it slips after a step.
  const double slower =
      are_few_ ? along_surface(SlipGoingOn(added.a, added.b, place) - run - slip).norm() : inverse_mass * grip.load;
  const double soon = std::max(slower, pull_ * point.friction * step_size_);
  const Vector3 sliding = along_surface(-(point.relative_velocity + pair.surface_velocity));
  const bool slides = grip.load > 0 && std::min(slip.norm(), sliding.norm()) > kSlides * soon;
  const bool bears = grip.bears && !slides && slip.norm() <= kKnownPart * inverse_mass * grip.load;
  // What slides tells its direction itself, however much it carries.
  Vector3 along = slip;
  if (!pair.drawn.isZero(0) && !slides && (are_few_ || !rows_.empty())) {
    // What joints and others will do about it shows in no slip before the solve. Among many it is noise.
    along += along_surface(-pair.drawn);
  } else if (bears) {
    along += ease / grip.count * grip.braked;
  } else if (slides) {
    // In the middle of the step, which is of second order.
    along = sliding;
  }
  std::array<Vector3, 2> directions;
  FindTangents(push, along, directions[0], directions[1]);
  if (bears && grip.may_share) {
    // Far from slipping, points hold along the load and across it in turns, each for its neighbour too.
    AddFriction(directions[number % 2], {place, run, impulse.normal, 2 * point.friction});
    return;
  }
  const Surface surface{place, run, impulse.normal, point.friction};
  AddFriction(directions[0], surface);
  // Sweeps follow the slip from step to step, so that one direction is enough for them where points lie beside each
  // other: each of them is in the way of what turns about another. What is solved all at once is held in both: a wheel
  // that is driven one way would drift the other. So is what may slip soon, or it would by what is left over across the
  // load, and among few points all that bears a load: a ball in a groove slips down either side before a solve, and
  // rolls another way. But not what slides: what it is held in one direction by would hold it in the other, too.
  const bool is_held = direct || (are_few_ && grip.bears);
  // Nor does anything tell a direction for what does not slip, and did not, where something in its island goes along
  // surfaces: that may be braked or pushed from now on, and what lies on it or below with it. What stands on an edge or
  // a corner tips over it, whatever went before, and where nothing else holds it it would slip another way in each step
  // if it were held in one.
  const bool may_tip = are_few_ && grip.is_on_a_line;
  const bool is_unknown = are_few_ && along.norm() < kNoDirection * soon && (goes_along_ || may_tip);
  const bool is_pivot = may_tip && grips_.AreAllOne() && along.norm() <= soon;
  if (bears || ((is_held || is_pivot) && !slides) || is_unknown) AddFriction(directions[1], surface);
}

void ContactSweeps::Impl::AddFriction(const Vector3& direction, const Surface& surface) {
  AddedPoint& point = points_.back();
  SolverRow& friction = frictions_.emplace_back();
  friction.a = normals_.back().a;
  friction.b = normals_.back().b;
  const double rate = FillPush(direction, surface.place, bodies_[friction.a], bodies_[friction.b], friction);
  friction.wanted = (surface.run.dot(direction) - rate) * friction.inverse;
  friction.friction = surface.friction;
  const double wanted = -point.impulse->friction.dot(direction);
  const double bound = surface.friction * surface.pressing;
  StartFrom(std::clamp(wanted, -bound, bound), friction);
  ++point.end_friction;
}

void ContactSweeps::Impl::AddTorsions() {
  for (size_t i = 0; i < normals_.size(); ++i) {
    const MixedMaterial& material = points_[i].pair->material;
    const auto number = static_cast<uint32_t>(i);
    if (material.spinning_friction > 0) AddTorsion(number, -points_[i].point->normal, material.spinning_friction);
    if (material.rolling_friction > 0) AddRolling(number);
  }
}

void ContactSweeps::Impl::AddRolling(uint32_t number) {
  const ContactPair& pair = *points_[number].pair;
  const SolverRow& normal = normals_[number];
  const double arm = pair.material.rolling_friction;
  const Vector3 axis = -points_[number].point->normal;
  const auto across = [&](const Vector3& spin) -> Vector3 { return spin - axis * axis.dot(spin); };
  const SweptBody &a = bodies_[normal.a], &b = bodies_[normal.b];
  const Vector3 spin = across(b.angular_velocity - a.angular_velocity), rolling = across(pair.rolling);
  const double speed = spin.norm(), speed_in_middle = rolling.norm();
  // What rolls on for some steps is braked against how it does in the middle of this one, which is of second order, and
  // not held across.
  const double weight = pull_ * step_size_ / (a.inverse_mass + b.inverse_mass);
  const double most = arm * std::max(pair.point_count * normal.impulse, weight);
  const double soon = ((a.inverse_tensor + b.inverse_tensor) * rolling).norm() * most;
  if (std::min(speed, speed_in_middle) * speed_in_middle > kSlides * soon) {
    AddTorsion(number, rolling / speed_in_middle, arm);
    return;
  }
  // What is solved all at once has a bound for each line alone: along the rolling it is the same whatever way that
  // goes.
  const Vector3 first = speed > kNoSpin ? Vector3(spin / speed) : axis.unitOrthogonal();
  AddTorsion(number, first, arm).is_first_of_two = true;
  AddTorsion(number, axis.cross(first), arm);
}

ContactSweeps::Impl::Torsion& ContactSweeps::Impl::AddTorsion(uint32_t normal_index, const Vector3& axis, double arm) {
  const SolverRow& normal = normals_[normal_index];
  Torsion& to = torsions_.emplace_back();
  to.a = normal.a;
  to.b = normal.b;
  to.normal = normal_index;
  to.arm = arm;
  FillJointRow({.kind = JointRow::Kind::kAngular, .axis = axis}, bodies_[to.a], bodies_[to.b], to);
  const double bound = arm * normal.impulse;
  const double turned = points_[normal_index].impulse->torque.dot(axis);
  StartFrom(std::clamp(turned, -bound, bound), to);
  return to;
}

}  // namespace genphys

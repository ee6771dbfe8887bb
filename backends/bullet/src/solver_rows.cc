// What contacts and joints come to before they are solved: the rows of the solver, what these start from, and along
// what friction works.
#include <algorithm>
#include <array>
#include <cmath>

#include "contact_rows.h"
#include "contact_solver.h"

namespace genphys::bullet_backend {
namespace {

// Less than the twice from which on friction that follows the slip overshoots.
constexpr double kEasy = 1.5;
// Of the slip that there would be without what friction did: with more than this part of it, the slip itself tells its
// direction.
constexpr double kKnownPart = 0.9;
// What is so many times as fast as friction slows it down in a step slides on for some steps.
constexpr double kSlides = 4;
// What slips no faster than this part of what friction gives in a step says nothing of where to.
constexpr double kNoDirection = 1e-6;
// rad/s: what turns more slowly has no direction.
constexpr double kNoSpin = 1e-9;

btVector3 VelocityAt(const btSolverBody& body, const btVector3& place) {
  return body.m_linearVelocity + body.m_angularVelocity.cross(place - body.m_worldTransform.getOrigin());
}

// m/s per N*s, of one side against the other.
double Mobility(const btVector3& direction, const btVector3& place, const btSolverBody& a, const btSolverBody& b) {
  SolverRow row;
  FillPush(direction, place, a, b, row);
  return row.mobility;
}

}  // namespace

void ContactSolver::convertJoints(btTypedConstraint**, int, const btContactSolverInfo& info) {
  for (const AddedRow& added : rows_) {
    BoundedRow& to = joints_.emplace_back();
    to.a = SolverBodyOf(added.a, info.m_timeStep);
    to.b = SolverBodyOf(added.b, info.m_timeStep);
    FillJointRow(*added.row, BodyAt(to.a), BodyAt(to.b), to);
  }
}

void ContactSolver::convertContacts(btPersistentManifold**, int, const btContactSolverInfo& info) {
  FindGoingOn(info.m_timeStep);
  grips_.Find(pairs_, is_direct_, are_few_);
  for (size_t number = 0; number < pairs_.size(); ++number) {
    const AddedPair& added = pairs_[number];
    const int id_a = SolverBodyOf(added.a, info.m_timeStep), id_b = SolverBodyOf(added.b, info.m_timeStep);
    const Grip grip = grips_.Of(number);
    for (size_t i = 0; i < added.points.size(); ++i) {
      if (!added.points[i].is_ahead) AddPoint(id_a, id_b, added, i, grip);
    }
  }
  AddTorsions();
  moves_.clear();
  for (const MotionChange& change : changes_) moves_.push_back({.inverse_mass = change.inverse_mass});
}

void ContactSolver::FindGoingOn(double step_size) {
  going_on_.clear();
  goes_along_ = false;
  if (!are_few_) return;
  const auto origin = [&](int id) { return FromBullet(BodyAt(id).m_worldTransform.getOrigin()); };
  // Impulses first.
  for (const AddedPair& added : pairs_) {
    const int id_a = SolverBodyOf(added.a, step_size), id_b = SolverBodyOf(added.b, step_size);
    going_on_.resize(changes_.size());
    const Vector3 center_a = origin(id_a), center_b = origin(id_b);
    MotionChange &a = going_on_[static_cast<size_t>(id_a)], &b = going_on_[static_cast<size_t>(id_b)];
    for (size_t i = 0; i < added.points.size(); ++i) {
      const ContactPoint& point = added.points[i];
      const PointImpulse& last = added.impulses[i];
      if (point.is_ahead) continue;
      goes_along_ = goes_along_ || GoesAlong(point, id_a, id_b);
      const Vector3 impulse = last.normal * point.normal + last.friction;
      a.linear.head<3>() -= impulse;
      b.linear.head<3>() += impulse;
      a.angular.head<3>() -= (point.position - center_a).cross(impulse) + last.torque;
      b.angular.head<3>() += (point.position - center_b).cross(impulse) + last.torque;
    }
  }
  for (size_t i = 0; i < going_on_.size(); ++i) {
    const btSolverBody& body = BodyAt(static_cast<int>(i));
    MotionChange& motion = going_on_[i];
    motion.linear = motion.linear * changes_[i].inverse_mass;
    motion.linear.head<3>() += FromBullet(body.m_linearVelocity);
    const Vector3 torque = motion.angular.head<3>();
    motion.angular.head<3>() = FromBullet(body.m_angularVelocity + Turned(body, ToBullet(torque)));
  }
}

btVector3 ContactSolver::SlipGoingOn(int a, int b, const btVector3& place) const {
  const auto velocity = [&](int id) -> btVector3 {
    const MotionChange& motion = going_on_[static_cast<size_t>(id)];
    const Vector3 linear = motion.linear.head<3>(), angular = motion.angular.head<3>();
    return ToBullet(linear) + ToBullet(angular).cross(place - m_tmpSolverBodyPool[id].m_worldTransform.getOrigin());
  };
  return velocity(a) - velocity(b);
}

bool ContactSolver::GoesAlong(const ContactPoint& point, int id_a, int id_b) const {
  const btVector3 place = ToBullet(point.position), normal = ToBullet(point.normal);
  const double least = kNoDirection * pull_ * point.friction * info_.m_timeStep;
  const auto goes = [&](int id) {
    const btVector3 velocity = VelocityAt(m_tmpSolverBodyPool[id], place);
    return (velocity - normal * normal.dot(velocity)).length2() > least * least;
  };
  return goes(id_a) || goes(id_b);
}

void ContactSolver::AddPoint(int id_a, int id_b, const AddedPair& added, size_t number, const Grip& grip) {
  const ContactPair& pair = *added.pair;
  ContactPoint& point = added.points[number];
  PointImpulse& impulse = added.impulses[number];
  btSolverBody &a = BodyAt(id_a), &b = BodyAt(id_b);
  const int first_friction = static_cast<int>(frictions_.size());
  points_.push_back({&point, &impulse, pair.material.rolling_friction, pair.material.spinning_friction, first_friction,
                     first_friction});
  // The points are those of the present poses: what was found for them is used in full. The solver then goes on over
  // many steps, and what rests comes to rest to the last digits.
  const btVector3 place = ToBullet(point.position), push = -ToBullet(point.normal);
  SolverRow& normal = normals_.emplace_back();
  normal.a = id_a;
  normal.b = id_b;
  const double apart =
      FillContact(point.depth, FillPush(push, place, a, b, normal), pair.correction, info_.m_timeStep, normal);
  if (apart > 0) pushes_.push_back({static_cast<int>(normals_.size()) - 1, apart, 0});
  StartFrom(impulse.normal, normal);
  AddFrictions(added, number, grip);
}

void ContactSolver::AddFrictions(const AddedPair& added, size_t number, const Grip& grip) {
  const ContactPair& pair = *added.pair;
  const ContactPoint& point = added.points[number];
  const PointImpulse& impulse = added.impulses[number];
  const SolverRow& normal = normals_.back();
  const int id_a = normal.a, id_b = normal.b;
  const btSolverBody &a = BodyAt(id_a), &b = BodyAt(id_b);
  const btVector3 place = ToBullet(point.position), push = -ToBullet(point.normal);
  // Friction works against the slip of the surfaces, which may run over their bodies. Where a load comes through other
  // contacts, nothing slips before a solve that would tell its direction, but what friction did in the last one tells
  // it.
  const btVector3 run = ToBullet(pair.surface_velocity + pair.bend);
  const auto along_surface = [&](const btVector3& v) { return v - push * push.dot(v); };
  const btVector3 slip = along_surface(VelocityAt(a, place) - VelocityAt(b, place) - run);
  const double ease = normal.mobility;
  const double inverse_mass = a.internalGetInvMass().x() + b.internalGetInvMass().x();
  // How much slower it slips after a step.
  const double slower =
      are_few_ ? along_surface(SlipGoingOn(id_a, id_b, place) - run - slip).length() : inverse_mass * grip.load;
  const double soon = std::max(slower, pull_ * point.friction * info_.m_timeStep);
  const btVector3 sliding = along_surface(-ToBullet(point.relative_velocity + pair.surface_velocity));
  const bool slides = grip.load > 0 && std::min(slip.length(), sliding.length()) > kSlides * soon;
  const bool bears = grip.bears && !slides && slip.length() <= kKnownPart * inverse_mass * grip.load;
  // What slides tells its direction itself, however much it carries.
  btVector3 along = slip;
  if (!pair.drawn.isZero(0) && !slides && (are_few_ || !rows_.empty())) {
    // What joints and others will do about it shows in no slip before the solve. Among many it is noise.
    along += along_surface(-ToBullet(pair.drawn));
  } else if (bears) {
    along += ease / grip.count * ToBullet(grip.braked);
  } else if (slides) {
    // In the middle of the step, which is of second order.
    along = sliding;
  }
  std::array<btVector3, 2> directions;
  FindTangents(push, along, directions[0], directions[1]);
  if (bears && grip.may_share) {
    // Far from slipping, points hold along the load and across it in turns, each for its neighbour too.
    AddFriction(directions[number % 2], {place, run, impulse.normal, 2 * point.friction});
    return;
  }
  const Surface surface{place, run, impulse.normal, point.friction};
  AddFriction(directions[0], surface);
  // Sweeps follow the slip from step to step, so that one direction is enough for them where points lie beside each
  // other: each of them is in the way of what turns about another. Of points on a line none is. What is more than twice
  // as easy to move across it as along it, because it may roll, overshoots by the part of friction that is across, and
  // by more in each step. What is solved all at once is held in both: a wheel that is driven one way would drift the
  // other. So is what may slip soon, or it would by what is left over across the load, and among few points all that
  // bears a load. But not what slides: what it is held in one direction by would hold it in the other, too.
  const bool is_held = is_direct_ || (are_few_ && grip.bears && !grip.is_on_a_line);
  const auto mobility = [&](const btVector3& direction) { return Mobility(direction, place, a, b); };
  const bool may_roll = grip.is_on_a_line && mobility(directions[1]) > kEasy * mobility(directions[0]);
  // Nor does anything tell a direction for what does not slip, and did not, where something in its island goes along
  // surfaces: that may be braked or pushed from now on, and what lies on it or below with it. What stands on an edge or
  // a corner tips over it, whatever went before, and where nothing else holds it it would slip another way in each step
  // if it were held in one.
  const bool may_tip = are_few_ && grip.is_on_a_line;
  const bool is_unknown = are_few_ && along.length() < kNoDirection * soon && (goes_along_ || may_tip);
  const bool is_pivot = may_tip && grips_.AreAllOne() && along.length() <= soon;
  if (bears || ((is_held || may_roll || is_pivot) && !slides) || is_unknown) AddFriction(directions[1], surface);
}

void ContactSolver::AddFriction(const btVector3& direction, const Surface& surface) {
  AddedPoint& point = points_.back();
  SolverRow& friction = frictions_.emplace_back();
  friction.a = normals_.back().a;
  friction.b = normals_.back().b;
  const double rate = FillPush(direction, surface.place, BodyAt(friction.a), BodyAt(friction.b), friction);
  friction.wanted = (surface.run.dot(direction) - rate) * friction.inverse;
  friction.friction = surface.friction;
  const double wanted = -point.impulse->friction.dot(FromBullet(direction));
  const double bound = surface.friction * surface.pressing;
  StartFrom(std::clamp(wanted, -bound, bound), friction);
  ++point.end_friction;
}

void ContactSolver::AddTorsions() {
  for (size_t i = 0; i < normals_.size(); ++i) {
    const AddedPoint& added = points_[i];
    if (added.rolling_friction == 0 && added.spinning_friction == 0) continue;
    const Vector3 axis = -added.point->normal;
    if (added.spinning_friction > 0) AddTorsion(static_cast<int>(i), axis, added.spinning_friction);
    if (added.rolling_friction == 0) continue;
    // What is solved all at once has a bound for each line alone: along the rolling it is the same whatever way that
    // goes.
    const Vector3 spin = FromBullet(BodyAt(normals_[i].b).m_angularVelocity - BodyAt(normals_[i].a).m_angularVelocity);
    const Vector3 across = spin - axis * axis.dot(spin);
    const double speed = across.norm();
    const Vector3 first = speed > kNoSpin ? Vector3(across / speed) : axis.unitOrthogonal();
    AddTorsion(static_cast<int>(i), first, added.rolling_friction).is_first_of_two = true;
    AddTorsion(static_cast<int>(i), axis.cross(first), added.rolling_friction);
  }
}

ContactSolver::Torsion& ContactSolver::AddTorsion(int normal_index, const Vector3& axis, double arm) {
  const SolverRow& normal = normals_[static_cast<size_t>(normal_index)];
  Torsion& to = torsions_.emplace_back();
  to.a = normal.a;
  to.b = normal.b;
  to.normal = normal_index;
  to.arm = arm;
  FillJointRow({.kind = JointRow::Kind::kAngular, .axis = axis}, BodyAt(to.a), BodyAt(to.b), to);
  const double bound = arm * normal.impulse;
  const double turned = points_[static_cast<size_t>(normal_index)].impulse->torque.dot(axis);
  StartFrom(std::clamp(turned, -bound, bound), to);
  return to;
}

}  // namespace genphys::bullet_backend

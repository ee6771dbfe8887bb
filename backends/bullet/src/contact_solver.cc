#include "contact_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "contact_rows.h"
#include "direct_solve.h"

namespace genphys::bullet_backend {
namespace {

constexpr int kIterationsMax = 100;
// Where no more than one point in so many is still stirred after a preset's iterations, these get some more, for
// kPointUpdates in all. To look at so many others costs as much as one turn.
constexpr size_t kStillStirred = 4;
constexpr size_t kLooksPerTurn = 8;
// Less than the twice from which on friction that follows the slip overshoots.
constexpr double kEasy = 1.5;
// Of the slip that there would be without what friction did: with more than this part of it, the slip itself tells its
// direction.
constexpr double kKnownPart = 0.9;
// Softness of a contact that is solved all at once, of its own mobility: the solver divides by what redundant contacts
// leave over.
constexpr double kDirectSoftness = 1e-7;
// m/s, as kSettled: what only goes on like that for ever is left.
constexpr double kNearlySettled = 1e-8;
// m: in a pile, a sweep that pushes something no further than this out of an overlap has left it where it was. What
// rests lies that deep from step to step. With a tenth of it 1,000 boxes in a pile take a fifth longer to overlap no
// less.
constexpr double kLeastPush = 1e-5;
// What is so many times as fast as friction slows it down in a step slides on for some steps.
constexpr double kSlides = 4;
// m/s^2, of the Earth.
constexpr double kGravity = 9.81;
// rad/s: what turns more slowly has no direction.
constexpr double kNoSpin = 1e-9;

btVector3 VelocityAt(const btSolverBody& body, const btVector3& place) {
  return body.m_linearVelocity + body.m_angularVelocity.cross(place - body.m_worldTransform.getOrigin());
}

// Visits 0..count-1, of many points one of each half in turns: rows that follow each other mostly share a body, and
// each of them would have to wait for what the one before it made of that. (A row takes 7 ns instead of 9.5.) Sweeps
// come nearer in the order of the pairs, and few points stay in it.
template <typename Visit>
void VisitPoints(size_t count, Visit visit) {
  const size_t half = count <= ContactSolver::kFewPoints ? count : (count + 1) / 2;
  for (size_t i = 0; i < half; ++i) {
    visit(i);
    if (half + i < count) visit(half + i);
  }
}

// m/s per N*s, of one side against the other.
double Mobility(const btVector3& direction, const btVector3& place, const btSolverBody& a, const btSolverBody& b) {
  SolverRow row;
  FillPush(direction, place, a, b, row);
  return row.mobility;
}

}  // namespace

ContactSolver::ContactSolver() : fixed_(0.0, nullptr, nullptr) {
  info_.m_splitImpulse = 1;
  info_.m_solverMode = 0;
  info_.m_leastSquaresResidualThreshold = kSettled * kSettled;
}

void ContactSolver::Begin(double step_size) {
  info_.m_timeStep = step_size;
  bodies_.clear();
  rows_.clear();
  pairs_.clear();
  points_.clear();
  normals_.clear();
  frictions_.clear();
  pushes_.clear();
  joints_.clear();
  torsions_.clear();
  changes_.clear();
  point_count_ = 0;
}

void ContactSolver::AddPair(Body* a, Body* b, const ContactPair& pair, std::span<ContactPoint> points,
                            std::span<PointImpulse> impulses, uint32_t few) {
  // Fewer iterations than a preset's do not find what all the more rows come to.
  pairs_.push_back({a, b, &pair, points, impulses, iterations_ >= kPresetIterations ? few : Leaps::kNone});
  point_count_ += points.size();
}

void ContactSolver::Solve(bool direct) {
  is_direct_ = direct;
  info_.m_numIterations = iterations_;
  if (iterations_ == kPresetIterations) {
    const size_t rows = 1 + rows_.size() + point_count_;
    const int affordable = static_cast<int>(kPointUpdates / rows);
    info_.m_numIterations = std::max(kPresetIterations, std::min(affordable, kIterationsMax));
  }
  solveGroup(bodies_.data(), static_cast<int>(bodies_.size()), nullptr, 0, nullptr, 0, info_, nullptr, nullptr);
}

int ContactSolver::SolverBodyOf(Body* body, double step_size) {
  const int id = getOrInitSolverBody(body != nullptr ? *body->rigid : fixed_, step_size);
  for (int next = static_cast<int>(changes_.size()); next < m_tmpSolverBodyPool.size(); ++next) {
    changes_.push_back({.inverse_mass = BodyAt(next).internalGetInvMass().x()});
  }
  return id;
}

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
  grips_.Find(pairs_, is_direct_);
  for (size_t number = 0; number < pairs_.size(); ++number) {
    const AddedPair& added = pairs_[number];
    const int id_a = SolverBodyOf(added.a, info.m_timeStep), id_b = SolverBodyOf(added.b, info.m_timeStep);
    const Grip grip = grips_.Of(number);
    for (size_t i = 0; i < added.points.size(); ++i) {
      if (added.points[i].is_ahead) {
        added.impulses[i] = {};
      } else {
        AddPoint(id_a, id_b, added, i, grip);
      }
    }
  }
  AddTorsions();
  moves_.clear();
  for (const MotionChange& change : changes_) moves_.push_back({.inverse_mass = change.inverse_mass});
}

void ContactSolver::FindGoingOn(double step_size) {
  going_on_.clear();
  const auto origin = [&](int id) { return FromBullet(BodyAt(id).m_worldTransform.getOrigin()); };
  // Impulses first.
  for (const AddedPair& added : pairs_) {
    if (!added.is_of_few()) continue;
    const int id_a = SolverBodyOf(added.a, step_size), id_b = SolverBodyOf(added.b, step_size);
    going_on_.resize(changes_.size());
    const Vector3 center_a = origin(id_a), center_b = origin(id_b);
    MotionChange &a = going_on_[static_cast<size_t>(id_a)], &b = going_on_[static_cast<size_t>(id_b)];
    for (size_t i = 0; i < added.points.size(); ++i) {
      const ContactPoint& point = added.points[i];
      const PointImpulse& last = added.impulses[i];
      if (point.is_ahead) continue;
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

void ContactSolver::AddPoint(int id_a, int id_b, const AddedPair& added, size_t number, const Grip& grip) {
  const ContactPair& pair = *added.pair;
  ContactPoint& point = added.points[number];
  PointImpulse& impulse = added.impulses[number];
  btSolverBody &a = BodyAt(id_a), &b = BodyAt(id_b);
  const int first_friction = static_cast<int>(frictions_.size());
  points_.push_back({&point, &impulse, pair.material.rolling_friction, pair.material.spinning_friction, first_friction,
                     first_friction, added.few});
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

  // Friction works against the slip of the surfaces, which may run over their bodies. Where a load comes through other
  // contacts, nothing slips before a solve that would tell its direction, but what friction did in the last one tells
  // it.
  const btVector3 run = ToBullet(pair.surface_velocity);
  const auto along_surface = [&](const btVector3& v) { return v - push * push.dot(v); };
  const btVector3 slip = along_surface(VelocityAt(a, place) - VelocityAt(b, place) - run);
  const double ease = normal.mobility;
  const double inverse_mass = a.internalGetInvMass().x() + b.internalGetInvMass().x();
  const double soon = std::max(inverse_mass * grip.load, kGravity * point.friction * info_.m_timeStep);
  const btVector3 sliding = along_surface(-ToBullet(point.relative_velocity) - run);
  const bool slides = grip.load > 0 && std::min(slip.length(), sliding.length()) > kSlides * soon;
  const bool bears = grip.bears && slip.length() <= kKnownPart * inverse_mass * grip.load;
  btVector3 along = slip;
  if (bears) {
    along += ease / grip.count * ToBullet(grip.braked);
  } else if (slides) {
    // In the middle of the step, which is of second order.
    along = sliding;
  } else if (grip.is_on_ground) {
    // Where a push out of the middle would turn a body, that slips before the solve another way than friction has to
    // hold it, and held along one wrong direction it creeps across that. So friction goes the way in which it held in
    // the last step, and against what would still slip if it did the same again.
    along = SlipGoingOn(id_a, id_b, place) - run + inverse_mass * ToBullet(grip.braked);
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
  const bool is_held = is_direct_ || (added.is_of_few() && grip.bears && !grip.is_on_a_line);
  const auto mobility = [&](const btVector3& direction) { return Mobility(direction, place, a, b); };
  const bool may_roll = grip.is_on_a_line && mobility(directions[1]) > kEasy * mobility(directions[0]);
  if (bears || ((is_held || may_roll) && !slides)) AddFriction(directions[1], surface);
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
    // The bound is one of each axis alone: along the rolling it is the same whatever way that goes.
    const Vector3 spin = FromBullet(BodyAt(normals_[i].b).m_angularVelocity - BodyAt(normals_[i].a).m_angularVelocity);
    const Vector3 across = spin - axis * axis.dot(spin);
    const double speed = across.norm();
    const Vector3 first = speed > kNoSpin ? Vector3(across / speed) : axis.unitOrthogonal();
    AddTorsion(static_cast<int>(i), first, added.rolling_friction);
    AddTorsion(static_cast<int>(i), axis.cross(first), added.rolling_friction);
  }
}

void ContactSolver::AddTorsion(int normal_index, const Vector3& axis, double arm) {
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
}

btScalar ContactSolver::solveSingleIteration(int, btCollisionObject**, int, btPersistentManifold**, int,
                                             btTypedConstraint**, int, const btContactSolverInfo&, btIDebugDraw*) {
  btScalar largest = 0;
  stirred_.BeginSweep();
  const auto note = [&](int a, int b, btScalar change) {
    stirred_.Note(a, b, change);
    largest = btMax(largest, btFabs(change));
  };
  const auto relax = [&](SolverRow& row, btScalar lower, btScalar upper) {
    note(row.a, row.b, Resolve(row, row.wanted, lower, upper));
  };
  const auto is_turn_of = [&](const SolverRow& row) { return stirred_.IsTurnOf(row.a, row.b); };
  turns_ = joints_.size();
  for (BoundedRow& row : joints_) note(row.a, row.b, Resolve(row));
  VisitPoints(normals_.size(), [&](size_t i) {
    SolverRow& row = normals_[i];
    if (!is_turn_of(row)) return;
    ++turns_;
    relax(row, 0, std::numeric_limits<double>::infinity());
  });
  VisitPoints(points_.size(), [&](size_t i) {
    if (!is_turn_of(normals_[i])) return;
    for (int j = points_[i].first_friction; j < points_[i].end_friction; ++j) {
      SolverRow& row = frictions_[static_cast<size_t>(j)];
      const btScalar bound = row.friction * normals_[i].impulse;
      // One that does not press has what it was started from taken out, and then nothing more.
      if (bound != 0 || row.impulse != 0) relax(row, -bound, bound);
    }
  });
  for (Torsion& row : torsions_) {
    const SolverRow& normal = normals_[static_cast<size_t>(row.normal)];
    if (!is_turn_of(normal)) continue;
    row.upper = row.arm * normal.impulse;
    row.lower = -row.upper;
    note(row.a, row.b, Resolve(row));
  }
  return largest * largest;
}

btScalar ContactSolver::solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int body_count,
                                                          btPersistentManifold** manifolds, int manifold_count,
                                                          btTypedConstraint** constraints, int constraint_count,
                                                          const btContactSolverInfo& info, btIDebugDraw* drawer) {
  const bool is_solved = is_direct_ && SolveDirectly();
  solveGroupCacheFriendlySplitImpulseIterations(bodies, body_count, manifolds, manifold_count, constraints,
                                                constraint_count, info, drawer);
  if (is_solved) return 0;
  stirred_.Begin(changes_, kSettled);
  size_t few_end = 0;
  for (const AddedPoint& point : points_) {
    if (point.few != Leaps::kNone) few_end = std::max<size_t>(few_end, point.few + 1);
  }
  if (few_end > 0) leaps_.Begin(normals_.size() + frictions_.size() + torsions_.size(), few_end);
  const size_t all = joints_.size() + normals_.size();
  size_t spare = iterations_ == kPresetIterations ? kPointUpdates : 0;
  for (int sweep = 1;; ++sweep) {
    const btScalar residual = solveSingleIteration(sweep, bodies, body_count, manifolds, manifold_count, constraints,
                                                   constraint_count, info, drawer);
    if (residual <= info.m_leastSquaresResidualThreshold) return residual;
    if (sweep >= info.m_numIterations) {
      const size_t work = turns_ + all / kLooksPerTurn;
      if (sweep >= kIterationsMax || kStillStirred * turns_ > all || work > spare) return residual;
      spare -= work;
    }
    const bool may_leap = few_end > 0 && sweep + Leaps::kSweepsBetween <= info.m_numIterations;
    if (may_leap && !Leap() && residual <= kNearlySettled * kNearlySettled) return residual;
  }
}

void ContactSolver::solveGroupCacheFriendlySplitImpulseIterations(btCollisionObject**, int, btPersistentManifold**, int,
                                                                  btTypedConstraint**, int,
                                                                  const btContactSolverInfo& info, btIDebugDraw*) {
  const double least = kLeastPush / info.m_timeStep;
  if (is_direct_ && PushDirectly(least)) return;
  const bool are_few = point_count_ <= kFewPoints;
  const double settled = are_few ? kSettled : least;
  // Of few none is passed over, or a stack would stand elsewhere by what rounding makes of its depths far away.
  pushed_.Begin(moves_, are_few ? 0 : settled);
  for (int sweep = 0; sweep < info.m_numIterations; ++sweep) {
    double largest = 0;
    pushed_.BeginSweep();
    for (ContactPush& push : pushes_) {
      const SolverRow& row = normals_[static_cast<size_t>(push.row)];
      if (!pushed_.IsTurnOf(row.a, row.b)) continue;
      const double change = Relax(row, push.wanted, 0, std::numeric_limits<double>::infinity(), push.impulse,
                                  moves_[static_cast<size_t>(row.a)], moves_[static_cast<size_t>(row.b)]);
      pushed_.Note(row.a, row.b, change);
      largest = std::max(largest, std::abs(change));
    }
    if (largest <= settled) return;
  }
}

bool ContactSolver::SolveDirectly() {
  DirectSolve solve(changes_);
  const auto add = [&](SolverRow& row, const DirectSolve::Bounds& bounds) {
    solve.Add(row, row.wanted, bounds, 0, kDirectSoftness, row.impulse);
  };
  for (BoundedRow& row : joints_) solve.Add(row, row.wanted, {row.lower, row.upper}, row.softness, 0, row.impulse);
  const int first_contact = static_cast<int>(joints_.size());
  for (SolverRow& row : normals_) add(row, {0, std::numeric_limits<double>::infinity()});
  for (size_t i = 0; i < points_.size(); ++i) {
    for (int j = points_[i].first_friction; j < points_[i].end_friction; ++j) {
      SolverRow& row = frictions_[static_cast<size_t>(j)];
      add(row, {-row.friction, row.friction, first_contact + static_cast<int>(i)});
    }
  }
  for (Torsion& row : torsions_) add(row, {-row.arm, row.arm, first_contact + row.normal});
  return solve.Run();
}

bool ContactSolver::PushDirectly(double settled) {
  DirectSolve solve(moves_);
  double largest = 0;
  for (ContactPush& push : pushes_) {
    const SolverRow& row = normals_[static_cast<size_t>(push.row)];
    solve.Add(row, push.wanted, {0, std::numeric_limits<double>::infinity()}, 0, kDirectSoftness, push.impulse);
    largest = std::max(largest, push.wanted * row.mobility);
  }
  if (largest <= settled) return true;
  // What joints lock stays together: what is opened here would be taken back as velocities, from step to step anew.
  for (BoundedRow& row : joints_) {
    if (std::isinf(row.lower) && std::isinf(row.upper)) {
      solve.Add(row, 0, {row.lower, row.upper}, row.softness, 0, row.pushed);
    }
  }
  return solve.Run();
}

btScalar ContactSolver::solveGroupCacheFriendlyFinish(btCollisionObject**, int, const btContactSolverInfo&) {
  for (size_t i = 0; i < rows_.size(); ++i) {
    rows_[i].row->impulse = joints_[i].impulse;
  }
  TakeImpulses();
  for (int i = 0; i < m_tmpSolverBodyPool.size(); ++i) {
    btSolverBody& solved = m_tmpSolverBodyPool[i];
    if (solved.m_originalBody == nullptr) continue;
    Body& body = *static_cast<Body*>(solved.m_originalBody->getUserPointer());
    const MotionChange &change = changes_[static_cast<size_t>(i)], &move = moves_[static_cast<size_t>(i)];
    body.motion.linear_velocity = FromBullet(solved.m_linearVelocity) + change.linear.head<3>();
    body.motion.angular_velocity = FromBullet(solved.m_angularVelocity) + change.angular.head<3>();
    body.motion.push = move.linear.head<3>();
    body.motion.turn = move.angular.head<3>();
    solved.m_originalBody->setCompanionId(-1);
  }
  m_tmpSolverBodyPool.resizeNoInitialize(0);
  return 0;
}

template <typename Visit>
void ContactSolver::VisitFew(Visit visit) {
  for (size_t i = 0; i < points_.size(); ++i) {
    const AddedPoint& point = points_[i];
    if (point.few == Leaps::kNone) continue;
    visit(normals_[i], 0, std::numeric_limits<double>::infinity(), point.few);
    for (int j = point.first_friction; j < point.end_friction; ++j) {
      SolverRow& row = frictions_[static_cast<size_t>(j)];
      const double bound = row.friction * normals_[i].impulse;
      visit(row, -bound, bound, point.few);
    }
  }
  for (Torsion& row : torsions_) {
    const auto normal = static_cast<size_t>(row.normal);
    const double bound = row.arm * normals_[normal].impulse;
    if (points_[normal].few != Leaps::kNone) visit(row, -bound, bound, points_[normal].few);
  }
}

bool ContactSolver::Leap() {
  leaps_.BeginSweep();
  VisitFew([&](const SolverRow& row, double, double, uint32_t few) { leaps_.Note(few, row.impulse, row.mobility); });
  if (!leaps_.Decide()) return !leaps_.leads_nowhere();
  size_t number = 0;
  VisitFew([&](SolverRow& row, double lower, double upper, uint32_t few) {
    const double far = leaps_.Of(number++, few);
    if (far == 0) return;
    const double before = row.impulse;
    row.impulse = std::clamp(before + far, lower, upper);
    const double change = row.impulse - before;
    Apply(row, change, ChangeOf(row.a), ChangeOf(row.b));
    stirred_.Note(row.a, row.b, change * row.mobility);
  });
  return true;
}

void ContactSolver::TakeImpulses() {
  for (size_t i = 0; i < points_.size(); ++i) {
    const AddedPoint& added = points_[i];
    Vector3 across = Vector3::Zero();
    for (int j = added.first_friction; j < added.end_friction; ++j) {
      const SolverRow& row = frictions_[static_cast<size_t>(j)];
      across -= row.push.head<3>() * row.impulse;
    }
    *added.impulse = {normals_[i].impulse, across, Vector3::Zero()};
    added.point->normal_impulse = added.impulse->normal;
    added.point->friction_impulse = added.impulse->friction;
  }
  for (const Torsion& row : torsions_) {
    points_[static_cast<size_t>(row.normal)].impulse->torque += row.impulse * row.turn_b.head<3>();
  }
}

}  // namespace genphys::bullet_backend

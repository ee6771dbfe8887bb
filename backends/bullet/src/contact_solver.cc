#include "contact_solver.h"

#include <algorithm>
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
// Softness of a contact that is solved all at once, of its own mobility: the solver divides by what redundant contacts
// leave over.
constexpr double kDirectSoftness = 1e-7;
// m/s, as kSettled: what only goes on like that for ever is left.
constexpr double kNearlySettled = 1e-8;
// m: in a pile, a sweep that pushes something no further than this out of an overlap has left it where it was. What
// rests lies that deep from step to step. With a tenth of it 1,000 boxes in a pile take a fifth longer to overlap no
// less.
constexpr double kLeastPush = 1e-5;

// Visits 0..count-1, of many points one of each half in turns: rows that follow each other mostly share a body, and
// each of them would have to wait for what the one before it made of that. (A row takes 7 ns instead of 9.5.) Sweeps
// come nearer in the order of the pairs, and few points stay in it, or go `back` in it.
template <typename Visit>
void VisitPoints(size_t count, bool back, Visit visit) {
  if (count <= ContactSolver::kFewPoints) {
    for (size_t i = 0; i < count; ++i) visit(back ? count - 1 - i : i);
    return;
  }
  const size_t half = (count + 1) / 2;
  for (size_t i = 0; i < half; ++i) {
    visit(i);
    if (half + i < count) visit(half + i);
  }
}

// Whether the sweep goes back from the last point to the first, as every second one does once a preset's iterations
// did not suffice. In one direction what happens at the one end of a tower comes to the other end in one sweep, but
// back only by a point in each: 15 flat boxes swayed until they stood half a metre beside each other.
bool GoesBack(int sweep) { return sweep > ContactSolver::kPresetIterations && sweep % 2 == 0; }

}  // namespace

ContactSolver::ContactSolver() : fixed_(0.0, nullptr, nullptr) {
  info_.m_splitImpulse = 1;
  info_.m_solverMode = 0;
  info_.m_leastSquaresResidualThreshold = kSettled * kSettled;
}

void ContactSolver::Begin(double step_size, double pull, bool are_few) {
  info_.m_timeStep = step_size;
  pull_ = pull;
  // Fewer iterations than a preset's do not find what all the more rows come to.
  are_few_ = are_few && iterations_ >= kPresetIterations;
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
                            std::span<PointImpulse> impulses) {
  pairs_.push_back({a, b, &pair, points, impulses});
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

btScalar ContactSolver::solveSingleIteration(int sweep, btCollisionObject**, int, btPersistentManifold**, int,
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
  VisitPoints(normals_.size(), GoesBack(sweep), [&](size_t i) {
    SolverRow& row = normals_[i];
    if (!is_turn_of(row)) return;
    ++turns_;
    relax(row, 0, std::numeric_limits<double>::infinity());
  });
  VisitPoints(points_.size(), GoesBack(sweep), [&](size_t i) {
    const AddedPoint& point = points_[i];
    if (!is_turn_of(normals_[i]) || point.first_friction == point.end_friction) return;
    SolverRow& first = frictions_[static_cast<size_t>(point.first_friction)];
    const btScalar bound = first.friction * normals_[i].impulse;
    if (point.end_friction - point.first_friction == 1) {
      // One that does not press has what it was started from taken out, and then nothing more.
      if (bound != 0 || first.impulse != 0) relax(first, -bound, bound);
      return;
    }
    SolverRow& second = frictions_[static_cast<size_t>(point.first_friction) + 1];
    if (bound == 0 && first.impulse == 0 && second.impulse == 0) return;
    note(first.a, first.b, RelaxInDisc(first, second, bound, ChangeOf(first.a), ChangeOf(first.b)));
  });
  for (size_t i = 0; i < torsions_.size(); i += torsions_[i].is_first_of_two ? 2 : 1) {
    Torsion& row = torsions_[i];
    const SolverRow& normal = normals_[static_cast<size_t>(row.normal)];
    if (!is_turn_of(normal)) continue;
    const double most = row.arm * normal.impulse;
    if (row.is_first_of_two) {
      note(row.a, row.b, RelaxInDisc(row, torsions_[i + 1], most, ChangeOf(row.a), ChangeOf(row.b)));
    } else {
      relax(row, -most, most);
    }
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
  if (are_few_) leaps_.Begin(normals_.size() + frictions_.size() + torsions_.size());
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
    // Of sweeps there and back only those that end alike are compared.
    if (sweep == kPresetIterations) leaps_.Forget();
    const bool is_alike = sweep < kPresetIterations || GoesBack(sweep);
    const bool may_leap = are_few_ && is_alike && sweep + Leaps::kSweepsBetween <= info.m_numIterations;
    if (may_leap && !Leap() && residual <= kNearlySettled * kNearlySettled) return residual;
  }
}

void ContactSolver::solveGroupCacheFriendlySplitImpulseIterations(btCollisionObject**, int, btPersistentManifold**, int,
                                                                  btTypedConstraint**, int,
                                                                  const btContactSolverInfo& info, btIDebugDraw*) {
  const double least = kLeastPush / info.m_timeStep;
  if (is_direct_ && PushDirectly(least)) return;
  const bool is_small = point_count_ <= kFewPoints;
  const double settled = is_small ? kSettled : least;
  // Of few none is passed over, or a stack would stand elsewhere by what rounding makes of its depths far away.
  pushed_.Begin(moves_, is_small ? 0 : settled);
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
void ContactSolver::VisitRows(Visit visit) {
  for (size_t i = 0; i < points_.size(); ++i) {
    const AddedPoint& point = points_[i];
    visit(normals_[i], 0, std::numeric_limits<double>::infinity());
    for (int j = point.first_friction; j < point.end_friction; ++j) {
      SolverRow& row = frictions_[static_cast<size_t>(j)];
      const double bound = row.friction * normals_[i].impulse;
      visit(row, -bound, bound);
    }
  }
  for (Torsion& row : torsions_) {
    const double bound = row.arm * normals_[static_cast<size_t>(row.normal)].impulse;
    visit(row, -bound, bound);
  }
}

bool ContactSolver::Leap() {
  leaps_.BeginSweep();
  VisitRows([&](const SolverRow& row, double, double) { leaps_.Note(row.impulse, row.mobility); });
  if (!leaps_.Decide()) return !leaps_.leads_nowhere();
  size_t number = 0;
  VisitRows([&](SolverRow& row, double lower, double upper) {
    const double before = row.impulse;
    row.impulse = std::clamp(before + leaps_.Of(number++), lower, upper);
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

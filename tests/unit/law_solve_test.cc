// Rows of contacts and joints, solved all at once.
#include "core/src/contacts/law_solve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/src/contacts/direct_solve.h"

namespace genphys {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
constexpr double kSlack = 1e-7;  // of the mobility

// Bodies that contacts and joints hold; the first one is what nothing moves.
struct Held {
  struct Row {
    SolverRow row;
    DirectSolve::Bounds bounds;
    double wanted;  // m/s
    bool is_first_of_two = false;
    double foretold = 0;
  };

  Held() { Add(0); }

  double Any() { return std::uniform_real_distribution(-1.0, 1.0)(dice); }
  Vector3 AnyVector() { return {Any(), Any(), Any()}; }

  uint32_t Add(double inverse_mass, const Vector3& center = Vector3::Zero()) {
    SweptBody& body = bodies.emplace_back();
    body.center = center;
    body.inverse_mass = inverse_mass;
    body.inverse_tensor = inverse_mass * Vector3(3, 2, 5).asDiagonal();
    changes.push_back({.inverse_mass = inverse_mass});
    return static_cast<uint32_t>(bodies.size() - 1);
  }

  // Pushes `a` along `axis` there, and b against it; returns its number.
  int Push(uint32_t a, uint32_t b, const Vector3& axis, const Vector3& place, double wanted,
           const DirectSolve::Bounds& bounds) {
    Row& row = rows.emplace_back();
    row.row.a = a;
    row.row.b = b;
    FillPush(axis, place, bodies[a], bodies[b], row.row);
    row.bounds = bounds;
    row.wanted = wanted;
    return static_cast<int>(rows.size() - 1);
  }

  void Touch(uint32_t a, uint32_t b, const Vector3& normal, const Vector3& place, const Vector3& wanted,
             double friction) {
    const int pressing = Push(a, b, normal, place, wanted.x(), {0, kEndless});
    const Vector3 first = normal.unitOrthogonal();
    Push(a, b, first, place, wanted.y(), {-friction, friction, pressing});
    rows.back().is_first_of_two = true;
    Push(a, b, normal.cross(first), place, wanted.z(), {-friction, friction, pressing});
  }

  void Tie(uint32_t a, uint32_t b, const Vector3& place) {
    for (int i = 0; i < 3; ++i) Push(a, b, Vector3::Unit(i), place, Any(), {-kEndless, kEndless});
  }

  bool Solve(BoundedSolver* bounded = nullptr) {
    DirectSolve solve;
    solve.Begin(changes);
    for (Row& row : rows) {
      solve.Add(row.row, row.wanted * row.row.inverse, row.bounds, 0, kSlack, row.row.impulse, row.foretold);
      if (row.is_first_of_two) solve.PairLast();
    }
    return solve.Run(bounded);
  }

  // How fast it still is against what a row wants, m/s.
  double RateOf(const Row& row) const {
    return RateOf(row.row, changes[row.row.a], changes[row.row.b]) + kSlack * row.row.impulse / row.row.inverse -
           row.wanted;
  }
  static double RateOf(const SolverRow& row, const MotionChange& a, const MotionChange& b) {
    return genphys::RateOf(row, a, b);
  }

  // The worst of what is not as bounds and Coulomb's law want it, of what impulses do by themselves or else of 1 m/s.
  double Lacking() const {
    double worst = 0, strongest = 1;
    for (size_t i = 0; i < rows.size(); ++i) {
      const Row& row = rows[i];
      const double mobility = 1 / row.row.inverse, impulse = row.row.impulse;
      strongest = std::max(strongest, mobility * std::abs(impulse));
      if (row.bounds.bounded_by == BoundedSolver::kFree) {
        const double free = impulse - RateOf(row) / mobility;
        worst = std::max(worst, mobility * std::abs(impulse - std::clamp(free, row.bounds.lower, row.bounds.upper)));
      } else if (row.is_first_of_two) {
        const double most = row.bounds.upper * rows[static_cast<size_t>(row.bounds.bounded_by)].row.impulse;
        const Eigen::Vector2d both(impulse, rows[i + 1].row.impulse);
        Eigen::Vector2d free = both - Eigen::Vector2d(RateOf(row), RateOf(rows[i + 1])) / mobility;
        if (free.norm() > most) free *= most / free.norm();
        worst = std::max(worst, mobility * (both - free).norm());
      }
    }
    return worst / strongest;
  }

  std::mt19937 dice{5};
  std::vector<SweptBody> bodies;
  std::vector<MotionChange> changes;
  std::vector<Row> rows;
};

TEST(LawSolve, FrictionOfAPointIsCoulombs) {
  constexpr double kMass = 2, kPressing = 3, kFriction = 0.5;
  for (const double push : {0.1, 1.0, 1.4, 1.6, 10.0, 1e3}) {
    for (double angle = 0; angle < 6.3; angle += 0.1) {
      Held held;
      const Eigen::Vector2d wanted = push * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      held.Touch(held.Add(1 / kMass), 0, Vector3::UnitZ(), Vector3::Zero(), {kPressing, wanted.x(), wanted.y()},
                 kFriction);
      ASSERT_TRUE(held.Solve());
      EXPECT_NEAR(held.rows[0].row.impulse, kMass * kPressing, 1e-5);
      const Eigen::Vector2d expected = kMass * std::min(push, kFriction * kPressing) / push * wanted;
      const Eigen::Vector2d found(held.rows[1].row.impulse, held.rows[2].row.impulse);
      EXPECT_LE((found - expected).norm(), 1e-5) << push << " at " << angle;
    }
  }
}

TEST(LawSolve, WhatDoesNotPressHasNoFriction) {
  Held held;
  held.Touch(held.Add(1), 0, Vector3::UnitZ(), {0.3, 0.2, 0}, {-1, 3, 4}, 0.5);
  ASSERT_TRUE(held.Solve());
  for (const Held::Row& row : held.rows) EXPECT_EQ(row.row.impulse, 0);
}

TEST(LawSolve, ADriveGivesWhatItMayAndALimitOnlyPushes) {
  for (const double wanted : {-3.0, -1.0, 1.0, 3.0}) {
    Held held;
    const uint32_t body = held.Add(1);
    held.Push(body, 0, Vector3::UnitX(), Vector3::Zero(), wanted, {-2, 2});
    held.Push(body, 0, Vector3::UnitY(), Vector3::Zero(), wanted, {0, kEndless});
    ASSERT_TRUE(held.Solve());
    EXPECT_NEAR(held.rows[0].row.impulse, std::clamp(wanted, -2.0, 2.0), 1e-6);
    EXPECT_NEAR(held.rows[1].row.impulse, std::max(wanted, 0.0), 1e-6);
  }
}

// Chains that lie, hang and stand on each other, with limits and drives.
Held AnyHeap(unsigned seed) {
  Held held;
  held.dice.seed(seed);
  for (int i = 0; i < 12; ++i) held.Add(std::exp(held.Any()), Vector3(0.4 * i, 0, 1) + 0.1 * held.AnyVector());
  for (uint32_t body = 1; body <= 12; ++body) {
    const Vector3 center = held.bodies[body].center;
    if (body % 4 != 1) {
      held.Tie(body, body - 1, (center + held.bodies[body - 1].center) / 2);
      held.Push(body, body - 1, held.AnyVector().normalized(), center, held.Any(), {-0.2, 0.2});
      held.Push(body, body - 1, held.AnyVector().normalized(), center, held.Any(), {0, kEndless});
    }
    for (int point = 0; point < 2; ++point) {
      const Vector3 wanted(0.2 + held.Any(), held.Any(), held.Any());
      held.Touch(body, 0, Vector3::UnitZ(), center - 0.3 * Vector3::UnitZ() + 0.2 * held.AnyVector(), wanted, 0.5);
    }
  }
  held.Touch(2, 7, Vector3::UnitX(), {1, 0, 1}, {0.3, 0.1, 0}, 0.8);
  held.Touch(9, 4, Vector3::UnitY(), {1, 0.3, 1}, {0.2, -0.1, 0.4}, 0.3);
  return held;
}

TEST(LawSolve, AHeapObeysItsLawsOrIsLeftAsItIs) {
  int solved = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Held held = AnyHeap(seed);
    if (held.Solve()) {
      ++solved;
      EXPECT_LE(held.Lacking(), 1e-5) << seed;
      continue;
    }
    for (const Held::Row& row : held.rows) EXPECT_EQ(row.row.impulse, 0) << seed;
    for (const MotionChange& change : held.changes) EXPECT_TRUE(change.linear.isZero(0)) << seed;
  }
  EXPECT_GE(solved, 180);
}

TEST(LawSolve, WhatStartsFromTheLastSolutionStaysThere) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Held held = AnyHeap(seed);
    if (!held.Solve()) continue;
    Held again = AnyHeap(seed);
    for (size_t i = 0; i < held.rows.size(); ++i) again.rows[i].foretold = held.rows[i].row.impulse;
    ASSERT_TRUE(again.Solve()) << seed;
    for (size_t i = 0; i < held.changes.size(); ++i) {
      EXPECT_LE((again.changes[i].linear - held.changes[i].linear).norm(), 1e-5) << seed;
    }
  }
}

TEST(LawSolve, LeavesAloneWhatNoNumberIsLargeEnoughFor) {
  for (const double wanted : {1e290, 1e308, std::numeric_limits<double>::infinity(), std::nan("")}) {
    Held held;
    held.Touch(held.Add(1e-20), held.Add(1e-20), Vector3::UnitZ(), {1e10, 0, 0}, {wanted, 0, 0}, 0.5);
    EXPECT_FALSE(held.Solve()) << wanted;
    for (const Held::Row& row : held.rows) EXPECT_EQ(row.row.impulse, 0);
    for (const MotionChange& change : held.changes) EXPECT_TRUE(change.linear.isZero(0));
  }
}

TEST(LawSolve, IsJammedWhereTwoWantTheOppositeOfWhatNothingMoves) {
  Held held;
  const uint32_t body = held.Add(1);
  held.Push(body, 0, Vector3::UnitZ(), Vector3::Zero(), 1, {-kEndless, kEndless});
  EXPECT_TRUE(Held(held).Solve());
  held.Push(body, 0, -Vector3::UnitZ(), Vector3::Zero(), 1, {0, kEndless});
  EXPECT_FALSE(held.Solve());
}

}  // namespace
}  // namespace genphys

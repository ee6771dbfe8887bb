#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>

#include "core/src/contacts/leaps.h"

namespace genphys {
namespace {

// Sweeps over rows that have the impulses which `impulse(row, sweep)` tells, until there is a leap. Returns in which
// sweep, or zero if there is none.
template <typename Impulse>
int SweepUntilALeap(Leaps& leaps, size_t rows, int sweeps, Impulse impulse) {
  leaps.Begin(rows);
  for (int sweep = 1; sweep <= sweeps; ++sweep) {
    leaps.BeginSweep();
    for (size_t row = 0; row < rows; ++row) leaps.Note(impulse(row, sweep), 1);
    if (leaps.Decide()) return sweep;
  }
  return 0;
}

TEST(Leaps, EndWhereSweepsWouldThatComeNearerByTheSamePartEachTime) {
  for (const double part : {0.55, 0.8, 0.96}) {
    Leaps leaps;
    const std::array<double, 3> end{1, -4, 0.5}, off{2, 3, -7};
    const auto impulse = [&](size_t row, int sweep) { return end[row] + off[row] * std::pow(part, sweep); };
    const int sweep = SweepUntilALeap(leaps, 3, 10, impulse);
    EXPECT_EQ(sweep, Leaps::kSweepsBetween);
    for (size_t row = 0; row < end.size(); ++row) {
      // What is left of rounding by a difference of a twenty-fifth.
      EXPECT_NEAR(impulse(row, sweep) + leaps.Of(row), end[row], 1e-11) << part;
    }
  }
}

TEST(Leaps, AreNoneWhereSweepsAreQuickOrHardlyComeNearerOrGoToAndFro) {
  for (const double part : {0.1, 0.45, 0.98, 1.0, 1.1, -0.9}) {
    Leaps leaps;
    EXPECT_EQ(SweepUntilALeap(leaps, 1, 20, [&](size_t, int sweep) { return 3 + std::pow(part, sweep); }), 0) << part;
  }
}

TEST(Leaps, WaitUntilOneWayIsLeft) {
  // Two ways across each other, of which one ends sooner.
  const auto impulse = [](size_t row, int sweep) { return row == 0 ? std::pow(0.9, sweep) : std::pow(0.5, sweep); };
  Leaps leaps;
  const int sweep = SweepUntilALeap(leaps, 2, 50, impulse);
  EXPECT_GT(sweep, Leaps::kSweepsBetween);
  EXPECT_LT(sweep, 20);
  EXPECT_NEAR(impulse(0, sweep) + leaps.Of(0), 0, 0.05 * impulse(0, sweep));
}

TEST(Leaps, WaitAnewWhereSweepsBecomeOthers) {
  Leaps leaps;
  leaps.Begin(1);
  const auto sweep = [&](double impulse) {
    leaps.BeginSweep();
    leaps.Note(impulse, 1);
    return leaps.Decide();
  };
  EXPECT_FALSE(sweep(0.9) || sweep(0.81));
  leaps.Forget();
  EXPECT_FALSE(sweep(0.729) || sweep(0.6561));
  EXPECT_TRUE(sweep(0.59049));
}

TEST(Leaps, LeadNowhereWhereImpulsesOnlyShiftFromOneToTheOther) {
  Leaps leaps;
  EXPECT_EQ(SweepUntilALeap(leaps, 2, 10, [](size_t row, int sweep) { return row == 0 ? sweep : -sweep; }), 0);
  EXPECT_TRUE(leaps.leads_nowhere());
  EXPECT_GT(SweepUntilALeap(leaps, 1, 10, [](size_t, int sweep) { return std::pow(0.8, sweep); }), 0);
  EXPECT_FALSE(leaps.leads_nowhere());
}

}  // namespace
}  // namespace genphys

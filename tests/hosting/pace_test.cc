#include <gtest/gtest.h>

#include "genphys/hosting/pace.h"

namespace genphys {
namespace {

using Clock = Pace::Clock;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr double kStepSize = 0.01;  // s
const Clock::time_point kStart(std::chrono::hours(1));
// Seconds in floating point become whole nanoseconds.
constexpr nanoseconds kRounding{2};

void ExpectAt(Clock::time_point time, Clock::time_point expected) {
  EXPECT_LE(std::chrono::abs(time - expected), kRounding) << (time - expected).count() << " ns off";
}

TEST(Pace, SpreadsStepsOverWallClockTimeByTheFactor) {
  ExpectAt(Pace(1, 5, kStart).Due(5 + kStepSize), kStart + milliseconds(10));
  ExpectAt(Pace(4, 5, kStart).Due(5 + 2 * kStepSize), kStart + milliseconds(5));
  ExpectAt(Pace(0.5, 5, kStart).Due(5 + kStepSize), kStart + milliseconds(20));
}

TEST(Pace, LeavesAWorldAtRestAloneForMinutesOrManySteps) {
  EXPECT_EQ(Pace(1, 0, kStart).RestFor(kStepSize), std::chrono::seconds(600));
  EXPECT_EQ(Pace(1e-300, 0, kStart).RestFor(kStepSize), std::chrono::seconds(600));
  EXPECT_EQ(Pace(1000, 0, kStart).RestFor(kStepSize), milliseconds(1000));
}

TEST(Pace, CountsTheStepsThatAreDueAndNeverOneTooMany) {
  for (const double factor : {0.1, 1.0, 30.0}) {
    const Pace pace(factor, 5, kStart);
    for (const double steps : {0.0, 1.0, 2.5, 100.0, 5000.3}) {
      const auto now = kStart + std::chrono::duration_cast<Clock::duration>(Pace::Seconds(steps * kStepSize / factor));
      const uint64_t due = pace.StepsDue(5, kStepSize, now);
      EXPECT_LE(static_cast<double>(due), steps);
      EXPECT_GE(static_cast<double>(due), steps - 4);
      EXPECT_LE(pace.Due(5 + static_cast<double>(due) * kStepSize), now);
    }
  }
  EXPECT_EQ(Pace(1, 5, kStart).StepsDue(5, kStepSize, kStart - milliseconds(1)), 0u);
}

TEST(Pace, OfZeroIsAlwaysDue) { EXPECT_LT(Pace(0, 5, kStart).Due(1e6), kStart); }

TEST(Pace, OfAlmostZeroIsDueInAYearAtMost) {
  EXPECT_EQ(Pace(1e-300, 0, kStart).Due(1), kStart + std::chrono::hours(24 * 365));
}

TEST(Pace, CountsStepsThatBeginMoreThanTheirDurationLate) {
  Pace pace(1, 0, kStart);
  const auto due = pace.Due(kStepSize);

  pace.Begin(due, kStepSize, due + milliseconds(9));
  EXPECT_EQ(pace.overruns(), 0u);
  pace.Begin(due, kStepSize, due + milliseconds(11));
  EXPECT_EQ(pace.overruns(), 1u);
}

TEST(Pace, CatchesUpWithAQuarterOfASecondAndLeavesTheRestBehind) {
  Pace pace(1, 0, kStart);
  const auto due = pace.Due(kStepSize);

  pace.Begin(due, kStepSize, due + milliseconds(200));
  ExpectAt(pace.Due(2 * kStepSize), kStart + milliseconds(20));
  pace.Begin(due, kStepSize, due + milliseconds(1250));
  ExpectAt(pace.Due(2 * kStepSize), kStart + milliseconds(20 + 1000));
}

}  // namespace
}  // namespace genphys

#include "genphys/hosting/pace.h"

#include <algorithm>

namespace genphys {

Pace::Clock::time_point Pace::Due(double simulation_time) const {
  if (factor_ == 0) return Clock::time_point::min();
  // A factor close to zero asks for a day that the clock cannot count to: there it simply never moves.
  constexpr Seconds kFarAway = std::chrono::hours(24 * 365);
  const Seconds elapsed((simulation_time - simulation_start_) / factor_);
  return start_ + std::chrono::duration_cast<Clock::duration>(elapsed < kFarAway ? elapsed : kFarAway);
}

Pace::Clock::duration Pace::RestFor(double step_size) const {
  const Seconds steps(kRestStepsMax * step_size / factor_);
  return std::chrono::duration_cast<Clock::duration>(std::min(kRestMax, steps));
}

uint64_t Pace::StepsDue(double simulation_time, double step_size, Clock::time_point now) const {
  // Sums of steps and the times when they are due are rounded.
  constexpr double kSpare = 2;
  const double steps = factor_ * Seconds(now - Due(simulation_time)).count() / step_size - kSpare;
  return steps > 0 ? static_cast<uint64_t>(std::min(steps, 2 * kRestStepsMax)) : 0;
}

void Pace::Begin(Clock::time_point due, double step_size, Clock::time_point now) {
  if (factor_ == 0) return;
  const Seconds late = now - due;
  if (late > Seconds(step_size / factor_)) ++overruns_;
  if (late > kCatchUpMax) start_ += std::chrono::duration_cast<Clock::duration>(late - kCatchUpMax);
}

}  // namespace genphys

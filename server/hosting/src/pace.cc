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

void Pace::Begin(Clock::time_point due, double step_size, Clock::time_point now) {
  if (factor_ == 0) return;
  const Seconds late = now - due;
  if (late > Seconds(step_size / factor_)) ++overruns_;
  if (late > kCatchUpMax) start_ += std::chrono::duration_cast<Clock::duration>(late - kCatchUpMax);
}

}  // namespace genphys

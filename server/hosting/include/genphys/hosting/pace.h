#pragma once
#include <chrono>
#include <cstdint>

namespace genphys {

/// When the steps of a playing world are due. A world that cannot keep up takes every step all the same, later: what it
/// is behind is caught up as fast as it can, but no more than kCatchUpMax of it, and every late step is counted.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;

  static constexpr Seconds kCatchUpMax{0.25};
  static constexpr Seconds kRestMax{600};
  static constexpr double kRestStepsMax = 100'000;

  /// `real_time_factor` simulated seconds per second, from `now` on; zero: as fast as possible.
  Pace(double real_time_factor, double simulation_time, Clock::time_point now)
      : factor_(real_time_factor), simulation_start_(simulation_time), start_(now) {}

  /// Whether steps have a time when they are due.
  bool is_timed() const { return factor_ != 0; }

  /// How long a world at rest may be left alone after `due`, to take the steps that were due meanwhile when somebody
  /// asks: they are only counted, so that a bound on their number keeps that short.
  Clock::duration RestFor(double step_size) const;

  /// How many steps of `step_size` from `simulation_time` on are due at `now`, or a few less.
  uint64_t StepsDue(double simulation_time, double step_size, Clock::time_point now) const;

  /// When the step that ends at `simulation_time` is to be taken.
  Clock::time_point Due(double simulation_time) const;

  /// The step of `step_size` that was due at `due` begins at `now`.
  void Begin(Clock::time_point due, double step_size, Clock::time_point now);

  /// Steps that began more than their own duration late.
  uint64_t overruns() const { return overruns_; }

 private:
  double factor_;
  double simulation_start_;  // s
  Clock::time_point start_;
  uint64_t overruns_ = 0;
};

}  // namespace genphys

#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "contenders/simulation.h"

namespace genphys::bench {

/// Follows a body that falls by `drop` (m) on a floor and bounces; `low` is the height of its centre when it lies
/// there.
class BounceWatch {
 public:
  BounceWatch(double low, double drop, double gravity) : low_(low), drop_(drop), gravity_(gravity) {}

  /// After each step.
  void See(const Motion& now, double time) {
    const double gap = now.position.z() - low_;
    const double jump = now.velocity.z() - speed_ + gravity_ * (time - time_);
    const bool bounced = jump > kJump;
    // What pushes it out of the floor may take more than one step; who was in the air and would have come down again
    // since the last look has bounced anew.
    if (bounced && (!bounced_before_ || ComesDown(time - time_))) {
      peaks_.push_back(0);
      slowest_ = std::numeric_limits<double>::infinity();
    }
    // The sample nearest the top of a flight tells its height, whatever the step size: from there on energy does.
    if (!peaks_.empty() && std::abs(now.velocity.z()) < slowest_) {
      slowest_ = std::abs(now.velocity.z());
      peaks_.back() = gap + now.velocity.z() * now.velocity.z() / (2 * gravity_);
    }
    if (std::abs(gap) > kRestGap || now.velocity.norm() > kRestSpeed) unrest_ = time;
    bounced_before_ = bounced;
    gap_ = gap;
    speed_ = now.velocity.z();
    time_ = time;
  }

  /// Of the four heights that it must come to, the worst, over the drop.
  double PeakError(double restitution) const {
    double worst = 0;
    for (int n = 0; n < kPeaks; ++n) {
      const double wanted = std::pow(restitution, 2 * (n + 1));
      const double got = static_cast<size_t>(n) < peaks_.size() ? peaks_[static_cast<size_t>(n)] / drop_ : 0;
      worst = std::max(worst, std::abs(got / wanted - 1));
    }
    return worst;
  }

  /// The last moment at which it was not at rest, s.
  double unrest() const { return unrest_; }

 private:
  static constexpr int kPeaks = 4;
  static constexpr double kJump = 0.05;       // m/s that weight does not explain
  static constexpr double kRestGap = 1e-4;    // m
  static constexpr double kRestSpeed = 1e-2;  // m/s

  // Whether it flew at the last look, upwards, and falls back onto the floor within `passed` seconds (s).
  bool ComesDown(double passed) const {
    return gap_ > 0 && speed_ > 0 && gap_ + (speed_ - gravity_ * passed / 2) * passed < 0;
  }

  double low_;
  double drop_;
  double gravity_;
  std::vector<double> peaks_;
  double slowest_ = 0;
  bool bounced_before_ = false;
  double gap_ = 0;
  double speed_ = 0;
  double time_ = 0;
  double unrest_ = 0;
};

}  // namespace genphys::bench

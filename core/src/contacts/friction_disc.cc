#include "genphys/friction_disc.h"

#include <algorithm>
#include <cmath>

namespace genphys {

double FrictionDisc::Follow(const Eigen::Vector2d& impulse, const Eigen::Vector2d& slip, double mobility, double most) {
  // Of what friction bears: steps are less exact than that, and each digit costs about one more solve.
  constexpr double kAgrees = 1e-5;
  // Of the mobility: what is softer turns none that slips so fast, and solvers divide by it.
  constexpr double kSoftest = 1e6;
  // m/s: friction that changes no speed by as much is none.
  constexpr double kNothing = 1e-12;
  most_ = most * mobility > kNothing ? most : 0;
  softness_ = 0;
  // What takes the slip away moves the impulse out of the disc where it slips, and Coulomb's impulse is the nearest one
  // in it, whatever mobility is taken.
  const Eigen::Vector2d free = impulse - slip / mobility;
  const double length = free.norm();
  Eigen::Vector2d nearest = free;
  if (length > most_) {
    nearest *= most_ / length;
    along_ = free / length;
    if (most_ > 0) softness_ = mobility * std::min(length / most_ - 1, kSoftest);
  }
  const double off = (impulse - nearest).norm();
  const bool agrees = off <= kAgrees * most_;
  Foretell();
  return agrees ? 0 : off * mobility;
}

void FrictionDisc::Foretell() {
  // Of one that hardly comes nearer nothing is known.
  constexpr double kSlowest = 0.9;
  const double bound = most_, last = bound - before_, first = before_ - long_before_;
  long_before_ = before_;
  before_ = bound;
  if (++known_ < 3 || !(std::abs(last) < kSlowest * std::abs(first))) return;
  most_ = std::max(bound + last * last / (first - last), 0.0);
  before_ = most_;
  known_ = 1;
}

}  // namespace genphys

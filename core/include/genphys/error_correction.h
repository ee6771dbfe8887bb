#pragma once
#include <optional>

namespace genphys {

/// How overlaps and the gaps of joints are taken away. Unset: as the world's default says, and there as the engine
/// does.
struct ErrorCorrection {
  std::optional<double> time_constant;  // s, in which a violation falls to 1 / e; zero: within each substep
  std::optional<double> speed_max;      // m/s, at which it is taken away
  std::optional<double> slop;           // m, that are left alone
  bool any() const { return time_constant || speed_max || slop; }
  bool operator==(const ErrorCorrection&) const = default;

  /// The part of a violation that a step of `step_size` seconds takes away: 1 - exp(-h / time constant).
  double PartOf(double step_size, double fallback) const;
};

/// `own` with every unset field taken from `defaults`.
ErrorCorrection Filled(const ErrorCorrection& own, const ErrorCorrection& defaults);

/// Of each field the gentler one of two sides; what one leaves unset the other decides.
ErrorCorrection Gentler(const ErrorCorrection& a, const ErrorCorrection& b);

}  // namespace genphys

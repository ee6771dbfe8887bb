#include "genphys/error_correction.h"

#include <algorithm>
#include <cmath>

namespace genphys {
namespace {

template <typename Choose>
std::optional<double> Either(const std::optional<double>& a, const std::optional<double>& b, Choose choose) {
  return a && b ? choose(*a, *b) : a ? a : b;
}

}  // namespace

double ErrorCorrection::PartOf(double step_size, double fallback) const {
  if (!time_constant) return fallback;
  return *time_constant > 0 ? -std::expm1(-step_size / *time_constant) : 1;
}

ErrorCorrection Filled(const ErrorCorrection& own, const ErrorCorrection& defaults) {
  const auto own_first = [](double given, double) { return given; };
  return {Either(own.time_constant, defaults.time_constant, own_first),
          Either(own.speed_max, defaults.speed_max, own_first), Either(own.slop, defaults.slop, own_first)};
}

ErrorCorrection Gentler(const ErrorCorrection& a, const ErrorCorrection& b) {
  // As it is nearly everywhere, and is asked for each pair.
  if (!a.any() && !b.any()) return {};
  const auto larger = [](double x, double y) { return std::max(x, y); };
  const auto smaller = [](double x, double y) { return std::min(x, y); };
  return {Either(a.time_constant, b.time_constant, larger), Either(a.speed_max, b.speed_max, smaller),
          Either(a.slop, b.slop, larger)};
}

}  // namespace genphys

#pragma once
#include <utility>

namespace genphys::testing {

/// Place and rate after `time`, s, in which law(place, rate) is the acceleration: Runge-Kutta, of fourth order, in so
/// many `parts`. Values are numbers or vectors.
template <typename Value, typename Law>
std::pair<Value, Value> CourseOf(Value place, Value rate, double time, int parts, const Law& law) {
  const double h = time / parts;
  for (int i = 0; i < parts; ++i) {
    const Value pull_a = law(place, rate);
    const Value place_b = place + h / 2 * rate, rate_b = rate + h / 2 * pull_a, pull_b = law(place_b, rate_b);
    const Value place_c = place + h / 2 * rate_b, rate_c = rate + h / 2 * pull_b, pull_c = law(place_c, rate_c);
    const Value place_d = place + h * rate_c, rate_d = rate + h * pull_c, pull_d = law(place_d, rate_d);
    place += h / 6 * (rate + 2 * rate_b + 2 * rate_c + rate_d);
    rate += h / 6 * (pull_a + 2 * pull_b + 2 * pull_c + pull_d);
  }
  return {place, rate};
}

}  // namespace genphys::testing

#include "genphys/leaps.h"

namespace genphys {
namespace {

// Of a change, across the one before it: with more than that it is no shrinking by the same part yet.
constexpr double kAstray = 0.03;
// The part of changes that is left after a sweep where a leap is worth its cost, and where it would go so far that
// rounding decides where to.
constexpr double kSlow = 0.5;
constexpr double kTooSlow = 0.97;
// The same of what no number of sweeps would bring nearer.
constexpr double kEndless = 0.995;

}  // namespace

void Leaps::Begin(size_t rows, size_t islands) {
  rows_.assign(rows, {});
  islands_.assign(islands, {});
}

void Leaps::Forget() {
  for (Island& island : islands_) island.since = 0;
}

bool Leaps::Decide() {
  bool is_any = false;
  leads_nowhere_ = true;
  for (Island& island : islands_) {
    const double part = island.before > 0 ? island.along / island.before : 0;
    const double across = island.now - part * island.along;
    const bool is_known = ++island.since >= kSweepsBetween && across <= kAstray * kAstray * island.now;
    const bool leaps = is_known && part > kSlow && part < kTooSlow;
    leads_nowhere_ = leads_nowhere_ && is_known && (part >= kEndless || island.now == 0);
    island = {.since = leaps ? 0 : island.since, .far = leaps ? part / (1 - part) : 0};
    is_any = is_any || leaps;
  }
  return is_any;
}

}  // namespace genphys

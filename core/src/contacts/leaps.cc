#include "contacts/leaps.h"

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

void Leaps::Begin(size_t rows) {
  rows_.assign(rows, {});
  since_ = 0;
}

bool Leaps::Decide() {
  const double part = before_ > 0 ? along_ / before_ : 0;
  const double across = now_ - part * along_;
  const bool is_known = ++since_ >= kSweepsBetween && across <= kAstray * kAstray * now_;
  const bool leaps = is_known && part > kSlow && part < kTooSlow;
  leads_nowhere_ = is_known && (part >= kEndless || now_ == 0);
  far_ = leaps ? part / (1 - part) : 0;
  if (leaps) since_ = 0;
  return leaps;
}

}  // namespace genphys

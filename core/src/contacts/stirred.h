#pragma once
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "contacts/solver_rows.h"

namespace genphys {

/// m/s or rad/s: what changes no more than this in a turn of a row is as good as solved. The next step goes on from
/// there.
inline constexpr double kSettled = 1e-9;

/// Which bodies the sweeps still change. A row neither of whose bodies has changed since its last turn would change
/// nothing, so that sweeps pass it over: of a large pile that lies still but for one corner they go through the corner.
class Stirred {
 public:
  /// Before the first sweep: every row has a turn in that. A change of no more than `settled` (m/s or rad/s) is none.
  void Begin(std::span<const MotionChange> bodies, double settled) {
    sweep_ = 0;
    settled_ = settled;
    changed_in_.assign(bodies.size(), 0);
    is_movable_.resize(bodies.size());
    for (size_t i = 0; i < bodies.size(); ++i) is_movable_[i] = bodies[i].inverse_mass > 0;
  }

  void BeginSweep() { ++sweep_; }

  /// Whether a row between these two has a turn.
  bool IsTurnOf(uint32_t a, uint32_t b) const { return IsStirred(a) || IsStirred(b); }

  /// What a turn of a row between these two did to its rate.
  void Note(uint32_t a, uint32_t b, double change) {
    if (std::abs(change) <= settled_) return;
    // Or all that lies on the same ground would stir all else that does.
    for (const uint32_t body : {a, b}) {
      if (is_movable_[body]) changed_in_[body] = sweep_;
    }
  }

 private:
  bool IsStirred(uint32_t body) const { return changed_in_[body] + 1 >= sweep_; }

  uint32_t sweep_ = 0;
  double settled_ = kSettled;
  std::vector<uint32_t> changed_in_;  // the last sweep, by body
  std::vector<uint8_t> is_movable_;   // by body
};

}  // namespace genphys

#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "case.h"
#include "contenders/contender.h"

namespace genphys::bench {

/// s, of each contender.
inline constexpr double kStepSize = 1.0 / 60;

/// Ours and the engine alone in the same scene, as parties of a race.
class Rivals {
 public:
  explicit Rivals(const Bench& bench) : bench_(bench) {}

  /// Starts `contender` in `scene` and takes the first `steps`. `prepare` is called before each turn and may be empty.
  void Add(const Contender& contender, const Scene& scene, uint32_t steps,
           const std::function<void(Simulation&)>& prepare = {});
  /// The engine alone, in its defaults and set up for speed.
  void AddRaw(const Scene& scene, uint32_t steps, const std::function<void(Simulation&)>& prepare = {});

  const std::vector<Party>& parties() const { return parties_; }
  Simulation& simulation(size_t place) { return *simulations_[place]; }
  /// The engine alone in its defaults.
  size_t naive() const { return raw_.front(); }
  /// The engine alone as it is fastest in `race`.
  size_t fastest(const Race& race) const;

 private:
  const Bench& bench_;
  std::vector<std::unique_ptr<Simulation>> simulations_;
  std::vector<Party> parties_;
  std::vector<size_t> raw_;  // places of the engine alone
};

}  // namespace genphys::bench

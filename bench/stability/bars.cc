#include "bars.h"

#include <cstdio>

namespace genphys::bench {
namespace {

void AddBoth(std::vector<Bar>& bars, const std::string& trial, const std::string& preset, const std::string& quantity,
             double largest) {
  for (const char* engine : {"ode", "bullet"}) {
    bars.push_back({trial, std::string("genphys-") + engine + '-' + preset, quantity, largest});
  }
}

}  // namespace

std::vector<Bar> Bars() {
  std::vector<Bar> bars;
  for (const char* stack : {"S1.5", "S1.10", "S1.15", "S1turned.5", "S1turned.10", "S1turned.15"}) {
    AddBoth(bars, stack, "balanced", "deviation", 0.25);
  }
  for (const char* stack : {"S1.15", "S1.20", "S1.30"}) AddBoth(bars, stack, "accurate", "deviation", 0.25);
  AddBoth(bars, "S2.1e2", "balanced", "penetration", 0.02);
  AddBoth(bars, "S2.1e2", "accurate", "penetration", 0.005);
  AddBoth(bars, "S2.1e4", "balanced", "penetration", 0.001);
  AddBoth(bars, "S2.1e4", "accurate", "penetration", 0.001);
  AddBoth(bars, "S3.hanging", "balanced", "gap", 1e-3);
  AddBoth(bars, "S3.swinging", "balanced", "gap", 1e-3);
  AddBoth(bars, "S3.swinging", "balanced", "energy_gain", 1e-2);
  AddBoth(bars, "S3.any", "balanced", "gap", 1e-3);
  AddBoth(bars, "S3.any", "balanced", "energy_gain", 1e-2);
  for (const char* shot : {"S4.3", "S4.10", "S4.50", "S4.300"}) {
    AddBoth(bars, shot, "balanced", "passed", 0);
    AddBoth(bars, shot, "balanced", "rebound", 1e-6);
  }
  AddBoth(bars, "S5", "balanced", "energy_gain", 1e-4);
  AddBoth(bars, "S5", "balanced", "momentum", 1e-3);
  AddBoth(bars, "S6", "balanced", "flips_missed", 0);
  AddBoth(bars, "S8.1e6", "balanced", "difference", 1e-6);
  AddBoth(bars, "S10", "balanced", "amplitude", 1.01);
  AddBoth(bars, "S11", "balanced", "energy_change", 1e-2);
  AddBoth(bars, "S12", "balanced", "energy_change", 1e-4);
  AddBoth(bars, "S13.elastic", "balanced", "energy_loss", 1e-3);
  AddBoth(bars, "S13.elastic", "balanced", "energy_gain", 1e-3);
  AddBoth(bars, "S13.elastic", "balanced", "momentum", 1e-12);
  AddBoth(bars, "S15", "balanced", "energy_excess", 0);
  AddBoth(bars, "S15", "balanced", "lost", 0);
  AddBoth(bars, "S16", "balanced", "replay_differs", 0);
  AddBoth(bars, "S16", "balanced", "energy_excess", 0.2);
  return bars;
}

int PrintBars(const std::vector<Outcome>& outcomes) {
  int missed = 0, looked_at = 0;
  for (const Bar& bar : Bars()) {
    for (const Outcome& outcome : outcomes) {
      if (outcome.trial != bar.trial || outcome.contender != bar.contender) continue;
      bool held = false;
      double worst = 0;
      for (const Quantity& quantity : outcome.worst) {
        if (quantity.name != bar.quantity) continue;
        worst = quantity.value;
        held = outcome.failure.empty() && worst <= bar.largest;
      }
      ++looked_at;
      missed += held ? 0 : 1;
      std::printf("%s  %-12s %-24s 1/%-5d %s <= %g: %.3g %s\n", held ? "pass" : "FAIL", bar.trial.c_str(),
                  bar.contender.c_str(), outcome.rate, bar.quantity.c_str(), bar.largest, worst,
                  outcome.failure.c_str());
    }
  }
  std::printf("%d of %d bars missed\n", missed, looked_at);
  return missed;
}

}  // namespace genphys::bench

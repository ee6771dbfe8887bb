#include "bars.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

namespace genphys::bench {
namespace {

using Rates = std::vector<int>;

class BarList {
 public:
  /// On both engines.
  void Both(const std::string& problem, const std::string& quantity, const Rates& rates, double limit) {
    Engine("ode", problem, quantity, rates, limit);
    Engine("bullet", problem, quantity, rates, limit);
  }

  void Engine(const std::string& engine, const std::string& problem, const std::string& quantity, const Rates& rates,
              double limit) {
    bars_.push_back({Bar::Kind::kQuantity, problem, quantity, rates, limit, "genphys-" + engine + "-balanced", ""});
  }

  // Between larger steps an error may still be small by chance.
  void Order(const std::string& problem, double least) {
    for (const char* engine : {"ode", "bullet"}) {
      bars_.push_back({Bar::Kind::kOrder,
                       problem,
                       "error",
                       {480, 2000},
                       least,
                       std::string("genphys-") + engine + "-balanced",
                       ""});
    }
  }

  void Cost(const std::string& problem, const std::string& preset, double times,
            const std::string& bullet_against = "raw-bullet") {
    bars_.push_back({Bar::Kind::kCost, problem, "", {60}, times, "genphys-ode-" + preset, "raw-ode-quick"});
    bars_.push_back({Bar::Kind::kCost, problem, "", {60}, times, "genphys-bullet-" + preset, bullet_against});
  }

  std::vector<Bar> Take() { return std::move(bars_); }

 private:
  std::vector<Bar> bars_;
};

void AddFlight(BarList& bars) {
  for (const char* problem : {"A1", "A1.random", "A2", "A2.random", "A7", "A7.random"}) {
    bars.Both(problem, "error", {}, 1e-12);
  }
  bars.Both("A5", "error", {60}, 1e-5);
  bars.Both("A5dz", "flips_missed", {60, 240, 1000}, 0);
  bars.Both("A5.long", "error", {240}, 1e-4);
  bars.Both("A5.long", "momentum", {240}, 1e-9);
  // On each engine, against the cheaper one alone.
  bars.Cost("T.tumblers", "balanced", 1, "raw-ode-quick");
}

void AddContact(BarList& bars) {
  for (const char* problem : {"C2", "C2.box", "C2i"}) {
    bars.Both(problem, "error", {60}, 2e-3);
    bars.Both(problem, "error", {240, 1000}, 1e-3);
    bars.Both(problem, "turn_degrees", {60, 240, 1000}, 0.1);
  }
  bars.Both("C1.stick", "creep", {240}, 1e-6);
  bars.Both("C1.slip", "acceleration", {240}, 1e-3);
  for (const char* problem : {"C3", "C19.ball", "C19.cylinder"}) {
    bars.Engine("ode", problem, "meters", {60}, 1e-4);
    bars.Engine("bullet", problem, "meters", {60}, 1e-3);
  }
  bars.Both("D1", "meters", {60, 240, 1000}, 1e-5);
  bars.Both("D2", "meters", {60, 240, 1000}, 1e-5);
  bars.Both("D3", "meters", {60}, 1e-2);
  bars.Order("D3", 1.8);
}

void AddImpacts(BarList& bars) {
  const Rates rates{60, 240, 1000};
  for (const std::string e : {"50", "80", "90"}) {
    bars.Both("C5.ball." + e, "error", rates, 1e-3);
    bars.Both("C5.ball." + e, "rest_time", {240}, 0.02);
    bars.Both("C5.ball." + e, "rest_time", {60}, 0.05);
    for (const std::string shape : {"box", "capsule", "hull", "mesh"}) {
      bars.Both("C5." + shape + '.' + e, "error", rates, 5e-3);
    }
  }
  bars.Both("C5.elastic", "error", rates, 1e-6);
  bars.Both("C5.slope", "error", rates, 5e-3);
  bars.Both("C5.spheres", "error", rates, 5e-3);
  bars.Both("C6.elastic", "error", rates, 1e-6);
  bars.Both("C6.half", "error", rates, 1e-6);
  bars.Both("C6.hung", "error", rates, 1e-3);
  bars.Both("C6.row", "error", rates, 1e-6);
  bars.Both("C7.elastic", "error", {240}, 1e-3);
  bars.Both("C7.90", "error", {240}, 1e-3);
  bars.Both("S13", "error", {240}, 1e-3);
  bars.Both("S13", "momentum", {240}, 1e-12);
  bars.Both("S13.box", "error", {240}, 1e-3);
  for (const char* problem : {"S4", "S4.free"}) {
    bars.Both(problem, "passed", {60, 240}, 0);
    bars.Both(problem, "error", {60, 240}, 1e-6);
  }
  bars.Both("S4.free", "momentum", {60, 240}, 1e-12);
  bars.Cost("T.falling", "balanced", 1.5);
}

void AddJointBars(BarList& bars) {
  bars.Both("B1", "meters", {240}, 5e-4);
  bars.Both("B3", "meters", {240}, 1e-3);
  bars.Both("B4", "meters", {240}, 5e-3);
  for (const char* problem : {"B1", "B3", "B4"}) bars.Order(problem, 1.8);
  bars.Both("B1.long", "error", {240}, 1e-2);
  bars.Both("B11.hanging", "error", {60}, 1e-3);
  bars.Both("B11.swinging", "error", {60}, 1e-3);
  bars.Order("A3", 1.8);
}

// The same of what dice choose.
void AddAnyBars(BarList& bars) {
  const Rates rates{60, 240, 1000};
  bars.Both("A5.any", "error", rates, 1e-9);
  bars.Both("A5.any", "energy", rates, 1e-4);
  bars.Both("C1.stick.any", "creep", {240}, 1e-6);
  bars.Both("C1.slip.any", "acceleration", {240}, 1e-3);
  bars.Both("C2.any", "error", {60}, 2e-3);
  bars.Both("C2.any", "error", {240, 1000}, 1e-3);
  bars.Both("C2.any", "turn_degrees", rates, 0.1);
  bars.Engine("ode", "C3.any", "meters", {60}, 1e-4);
  bars.Engine("bullet", "C3.any", "meters", {60}, 1e-3);
  bars.Both("C5.any", "error", rates, 1e-3);
  bars.Both("C5.any", "rest_time", {240}, 0.02);
  bars.Both("C5.any", "rest_time", {60}, 0.05);
  bars.Both("C6.any", "error", rates, 5e-3);
  bars.Order("B1.any", 1.8);
  bars.Both("B1.small", "error", {240}, 1e-3);
}

using Key = std::tuple<std::string, std::string, int>;

std::string Number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

class Verdicts {
 public:
  explicit Verdicts(const std::vector<Result>& results) {
    for (const Result& result : results) results_[{result.problem, result.contender, result.rate}] = &result;
  }

  int missed() const { return missed_; }
  int looked_at() const { return looked_at_; }

  void Look(const Bar& bar) {
    std::vector<Found> found;
    const std::vector<int>& rates = bar.rates.empty() ? kRates : bar.rates;
    switch (bar.kind) {
      case Bar::Kind::kQuantity:
        for (const int rate : rates) {
          const Result* result = Get(bar.problem, bar.contender, rate);
          if (result != nullptr) found.push_back({"1/" + std::to_string(rate), Find(*result, bar.quantity)});
        }
        return Tell(bar, bar.quantity, found);
      case Bar::Kind::kOrder: {
        const Result* coarse = Get(bar.problem, bar.contender, rates[0]);
        const Result* fine = Get(bar.problem, bar.contender, rates[1]);
        if (coarse != nullptr && fine != nullptr) found.push_back({"", OrderOf(*coarse, *fine)});
        return Tell(bar, "order", found);
      }
      case Bar::Kind::kCost: {
        const Result* ours = Get(bar.problem, bar.contender, rates[0]);
        const Result* theirs = Get(bar.problem, bar.against, rates[0]);
        if (ours == nullptr || theirs == nullptr || theirs->cpu == 0) return;
        const auto ratio = ours->cpu > 0 ? std::optional(ours->cpu / theirs->cpu) : std::nullopt;
        return Tell(bar, "cost / " + bar.against, {{"1/" + std::to_string(rates[0]), ratio}});
      }
    }
  }

 private:
  struct Found {
    std::string rate;
    std::optional<double> value;
  };

  const Result* Get(const std::string& problem, const std::string& contender, int rate) const {
    const auto found = results_.find({problem, contender, rate});
    return found == results_.end() ? nullptr : found->second;
  }

  static std::optional<double> OrderOf(const Result& coarse, const Result& fine) {
    const std::optional<double> a = Find(coarse, "error"), b = Find(fine, "error");
    if (!a || !b) return std::nullopt;
    return std::log(*a / *b) / std::log(static_cast<double>(fine.rate) / coarse.rate);
  }

  void Tell(const Bar& bar, const std::string& what, const std::vector<Found>& found) {
    if (found.empty()) return;
    const bool at_least = bar.kind == Bar::Kind::kOrder;
    const auto holds = [&](const Found& each) {
      return each.value && (at_least ? *each.value >= bar.limit : *each.value <= bar.limit);
    };
    const bool held = std::ranges::all_of(found, holds);
    ++looked_at_;
    missed_ += held ? 0 : 1;
    std::printf("%s  %-14s %-24s %s %s %g:", held ? "pass" : "FAIL", bar.problem.c_str(), bar.contender.c_str(),
                what.c_str(), at_least ? ">=" : "<=", bar.limit);
    for (const Found& each : found) {
      std::printf("  %s %s%s", each.rate.c_str(), each.value ? Number(*each.value).c_str() : "failed",
                  holds(each) || held ? "" : " !");
    }
    std::printf("\n");
  }

  std::map<Key, const Result*> results_;
  int missed_ = 0;
  int looked_at_ = 0;
};

}  // namespace

std::vector<Bar> Bars() {
  BarList bars;
  AddFlight(bars);
  AddContact(bars);
  AddImpacts(bars);
  AddJointBars(bars);
  bars.Cost("T.pile", "fast", 1.1);
  bars.Cost("T.pile", "balanced", 2.5);
  bars.Cost("T.joints", "fast", 1.1);
  bars.Cost("T.joints", "balanced", 2.5);
  AddAnyBars(bars);
  return bars.Take();
}

int PrintBars(const std::vector<Result>& results) {
  Verdicts verdicts(results);
  for (const Bar& bar : Bars()) verdicts.Look(bar);
  std::printf("%d of %d bars missed\n", verdicts.missed(), verdicts.looked_at());
  return verdicts.missed();
}

}  // namespace genphys::bench

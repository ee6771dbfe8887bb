#pragma once
#include <map>
#include <vector>

#include "genphys/contact.h"
#include "genphys/event.h"
#include "genphys/layer_state.h"
#include "genphys/pair_rule.h"
#include "genphys/state.h"

namespace genphys {

/// Gathers who touched whom in one step, over its substeps, and tells what began, went on and ended. Every engine's
/// contacts pass through here, so all of them report alike.
class StepTouches {
 public:
  StepTouches(const PairRule& rule, const StateArrays& state, const EventKinds& kinds)
      : rule_(rule), state_(state), kinds_(kinds) {}

  /// Takes the pairs that passed on an impulse in the substep just solved.
  void AddSolved(const ContactBuffer& contacts);

  /// Takes the pairs that are deep enough at the poses where the step ends.
  void AddFinal(const ContactBuffer& contacts);

  /// Keeps pairs of `before` that nothing looked at, since neither side was active in this step.
  void KeepUntested(const std::vector<TouchingPair>& before, const std::vector<uint8_t>& tested_rows);

  /// Who touches now, ascending.
  std::vector<TouchingPair> Pairs() const;

  /// What changed against `before`, in canonical order.
  void Report(const std::vector<TouchingPair>& before, std::vector<EventKind>& events) const;

 private:
  struct Touch {
    std::vector<EventContactPoint> points;
    double impulse_before = 0;  // N*s along normals, of substeps before the one that `points` shows
    bool solved = false;        // `points` carry impulses
  };

  TouchingPair PairOf(const ContactPair& pair) const;
  void Collect(const ContactBuffer& contacts, const ContactPair& pair, Touch& touch) const;
  std::vector<EventContactPoint> PointsOf(const TouchingPair& pair) const;

  const PairRule& rule_;
  const StateArrays& state_;
  const EventKinds& kinds_;
  std::map<TouchingPair, Touch> touches_;
};

}  // namespace genphys

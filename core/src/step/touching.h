#pragma once
#include <span>
#include <vector>

#include "genphys/contact.h"
#include "genphys/event.h"
#include "genphys/layer_state.h"
#include "genphys/pair_rule.h"
#include "genphys/row_marks.h"
#include "genphys/state.h"

namespace genphys {

/// What the points of a contact pass on together.
struct ContactImpulse {
  double normal = 0;                   // N*s, the sum of all
  Vector3 friction = Vector3::Zero();  // N*s
};

/// Gathers who touched whom in one step, over its substeps, and tells what began, went on and ended. Every engine's
/// contacts pass through here, so all of them report alike. Points are kept only of pairs that will be told of.
class StepTouches {
 public:
  /// `before` are the pairs that touched when the step began, ascending. All arguments outlive this object.
  StepTouches(const PairRule& rule, const StateArrays& state, const EventKinds& kinds,
              const std::vector<TouchingPair>& before)
      : rule_(rule), state_(state), kinds_(kinds), before_(before) {}

  /// Takes the pairs that passed on an impulse in the substep just solved.
  void AddSolved(const ContactBuffer& contacts);

  /// Takes the pairs of visitors that were inside sensors, or on their way through them, in the substep just done:
  /// those of `contacts` that are deep enough where it ends, and `visits`. Who is not inside when the step ends came
  /// and went.
  void AddVisits(const ContactBuffer& contacts, std::span<const ContactPair> visits);

  /// Takes the pairs that are deep enough at the poses where the step ends.
  void AddFinal(const ContactBuffer& contacts);

  /// Keeps those of before that nothing looked at, since neither side was active in this step.
  void KeepUntested(const RowMarks& tested);

  /// Who touches now, ascending.
  std::vector<TouchingPair> Pairs() const;

  /// What changed, in no particular order.
  void Report(std::vector<EventKind>& events) const;

 private:
  struct Touch {
    TouchingPair pair;
    bool solved = false;     // `points` carry impulses
    ContactImpulse earlier;  // of substeps besides the one that `points` shows
    std::vector<EventContactPoint> points;
    std::vector<EventContactPoint> first;  // in the step, of those who touched nobody before it
  };

  // A contact pair of a buffer by its place there, and whom it is between.
  struct Found {
    TouchingPair pair;
    uint32_t place = 0;
    auto operator<=>(const Found&) const = default;
  };

  TouchingPair PairOf(const ContactPair& pair) const;
  void Merge(const ContactBuffer& contacts, bool solved);
  static std::vector<EventContactPoint> PointsOf(const Touch& touch);
  void ReportNow(const Touch& touch, bool was, std::vector<EventKind>& events) const;
  void ReportVisits(std::vector<EventKind>& events) const;
  void ReportEnd(const TouchingPair& pair, std::vector<EventKind>& events) const;
  bool Touched(const TouchingPair& pair) const;
  bool WillBeTold(const TouchingPair& pair) const;
  void Collect(const ContactBuffer& contacts, const ContactPair& pair, std::vector<EventContactPoint>& points) const;

  const PairRule& rule_;
  const StateArrays& state_;
  const EventKinds& kinds_;
  const std::vector<TouchingPair>& before_;
  std::vector<Touch> touches_;  // ascending
  std::vector<TouchingPair> visits_;
  std::vector<Found> found_;  // scratch
};

}  // namespace genphys

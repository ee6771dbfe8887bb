#pragma once
#include <cstdint>
#include <vector>

namespace genphys {

/// Where sweeps lead to, told from how they go. What is left of an error after the first sweeps mostly shrinks by the
/// same part in each; what it will come to then follows from the last two (Aitken's delta-squared process, 1926; for
/// vectors, with the part by which they shrink along themselves: Jennings, 1971). Every island leaps by itself, so that
/// it does not matter what else is solved.
class Leaps {
 public:
  /// Sweeps after a leap from which on changes tell how it goes on: the first one undoes what the leap did to others,
  /// and the two after it are compared.
  static constexpr int kSweepsBetween = 3;

  /// Before the first sweep over so many rows of so many islands.
  void Begin(size_t rows, size_t islands);

  /// From now on sweeps are others than before, with which they cannot be compared.
  void Forget();

  /// Before the rows of a sweep are noted.
  void BeginSweep() { next_ = 0; }
  /// After a sweep, for each row in the same order: its impulse, and its `mobility`, m/s per N*s.
  void Note(uint32_t island, double impulse, double mobility) {
    Row& row = rows_[next_++];
    const double change = impulse - row.impulse;
    Island& own = islands_[island];
    own.before += mobility * row.change * row.change;
    own.now += mobility * change * change;
    own.along += mobility * change * row.change;
    row = {impulse, change};
  }

  /// When all are noted: whether any island leaps.
  bool Decide();

  /// Whether the last sweep brought nobody nearer, or hardly: what it still changed goes on so for ever, as impulses do
  /// that points shift from one to the other.
  bool leads_nowhere() const { return leads_nowhere_; }

  /// By how much (N*s) the impulse of the row that was noted as `number` leaps.
  double Of(size_t number, uint32_t island) const { return islands_[island].far * rows_[number].change; }

 private:
  struct Row {
    double impulse = 0;  // after the last sweep
    double change = 0;   // by it
  };
  struct Island {
    double before = 0;  // square of the changes in the sweep before the last one
    double now = 0;     // the same of the last one
    double along = 0;   // product of both
    int since = 0;      // sweeps since it leapt
    double far = 0;     // how many last changes it leaps by
  };

  std::vector<Row> rows_;
  std::vector<Island> islands_;
  size_t next_ = 0;
  bool leads_nowhere_ = false;
};

}  // namespace genphys

#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace genphys {

/// Where sweeps lead to, told from how they go. What is left of an error after the first sweeps mostly shrinks by the
/// same part in each; what it will come to then follows from the last two (Aitken's delta-squared process, 1926; for
/// vectors, with the part by which they shrink along themselves: Jennings, 1971). That is one for all rows: what does
/// not feel each other is to be swept by itself.
class Leaps {
 public:
  /// Sweeps after a leap from which on changes tell how it goes on: the first one undoes what the leap did to others,
  /// and the two after it are compared.
  static constexpr int kSweepsBetween = 3;

  /// Before the first sweep over so many rows.
  void Begin(size_t rows);

  /// From now on sweeps are others than before, with which they cannot be compared.
  void Forget() { since_ = 0; }

  /// Before the rows of a sweep are noted.
  void BeginSweep() {
    next_ = 0;
    before_ = now_ = along_ = 0;
  }
  /// After a sweep, for each row in the same order: its impulse, and its `mobility`, m/s per N*s.
  void Note(double impulse, double mobility) {
    Row& row = rows_[next_++];
    const double change = impulse - row.impulse;
    before_ += mobility * row.change * row.change;
    now_ += mobility * change * change;
    along_ += mobility * change * row.change;
    row = {impulse, change};
  }

  /// When all are noted: whether to leap.
  bool Decide();

  /// Whether the last sweep came no nearer, or hardly: what it still changed goes on so for ever, as impulses do that
  /// points shift from one to the other.
  bool leads_nowhere() const { return leads_nowhere_; }

  /// By how much (N*s) the impulse of the row that was noted as `number` leaps.
  double Of(size_t number) const { return far_ * rows_[number].change; }

 private:
  struct Row {
    double impulse = 0;  // after the last sweep
    double change = 0;   // by it
  };

  std::vector<Row> rows_;
  size_t next_ = 0;
  double before_ = 0;  // square of the changes in the sweep before the last one
  double now_ = 0;     // the same of the last one
  double along_ = 0;   // product of both
  int since_ = 0;      // sweeps since the last leap
  double far_ = 0;     // how many last changes to leap by
  bool leads_nowhere_ = false;
};

}  // namespace genphys

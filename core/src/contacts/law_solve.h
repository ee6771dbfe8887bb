#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contacts/direct_row.h"
#include "contacts/row_elimination.h"
#include "contacts/solver_rows.h"

namespace genphys {

/// Rows, solved all at once by Newton's method on what each of them obeys: it keeps its bodies as it wants, is at a
/// bound, or slips. Alart and Curnier, "A mixed formulation for frictional contact problems prone to Newton like
/// solution methods", Comput. Methods Appl. Mech. Eng. 92 (1991). An iteration takes about as long as there are rows,
/// and a few are enough where it soon turns out who obeys what, as where a solve begins with what the last one came to.
class LawSolve {
 public:
  /// Is to solve these, which last until it has; `bodies` are those that they name. False: they would take too long.
  bool Begin(std::span<const DirectRow> rows, std::span<const MotionChange> bodies);

  /// Starts from impulses by row, N*s or N*m*s, and has them after. False: who obeys what did not turn out.
  bool Run(Eigen::VectorXd& impulses);

 private:
  enum class Law : uint8_t { kAtBound, kHolds, kSlips };
  // Two rows across each other, or one, that together bear at most so many times what another one does.
  struct Disc {
    uint32_t row;
    uint32_t normal;
    double friction;
    bool is_pair;
    Law law = Law::kHolds;                             // at its bound: bears nothing, for nothing presses
    Eigen::Vector2d along = Eigen::Vector2d::UnitX();  // where it pushes what slips
    double softness = 0;                               // across that, 1/kg
  };
  // What a row has to do with one of its bodies.
  struct Side {
    uint32_t place;  // of the row in the order of elimination
    const DirectRow::Part* part;
  };
  struct Body {
    uint32_t first = 0, count = 0;  // of sides_
    size_t first_answer = 0;        // of answers_: a square of them
  };

  void FindLaws();
  void FindSides();
  void FindAnswers();
  bool IsMoved(const DirectRow::Part& part) const { return moved_[part.body].inverse_mass > 0; }
  std::span<const Side> SidesOf(const Body& body) const { return std::span(sides_).subspan(body.first, body.count); }
  Eigen::Vector2d Of(const Disc& disc, const Eigen::VectorXd& values) const;
  void Give(const Disc& disc, const Eigen::Vector2d& impulse);

  // What each obeys at first.
  void BeginLaws();
  // The same by its impulse alone, or where that says nothing by what it wants.
  void Foretell();
  // What each obeys as impulses and rates are. Impulses at bounds are brought there. False: that is what they obeyed.
  bool Judge();
  bool JudgeBox(uint32_t row, double rate);
  bool JudgeDisc(Disc& disc, const Eigen::Vector2d& rate, double most);

  void FindRates();
  double RateOf(uint32_t row) const;
  // How far it is from all laws, m/s or rad/s.
  double Lacking() const;
  double OffOf(const Disc& disc) const;
  bool IsSettled(double lacking, double before) const;

  // An iteration, with equations that `are_new` or those of the last one. False: they have no solution.
  bool Improve(bool are_new);
  void Choose();
  void Assemble();
  void TurnAnswers(const Disc& disc);
  void TakeChanges(const Eigen::VectorXd& changes);
  // One turn of each row.
  void Sweep();
  void BringTo(uint32_t row, double impulse);

  std::span<const DirectRow> rows_;
  RowElimination elimination_;
  std::vector<Law> laws_;        // by row that is of no disc
  std::vector<uint32_t> boxes_;  // rows with bounds of their own
  std::vector<Disc> discs_;
  std::vector<double> scales_;               // by row: how it answers to its own impulse, 1/kg
  std::vector<uint32_t> place_;              // by row, in the order of elimination
  std::vector<std::array<uint32_t, 2>> at_;  // by row, for a and b: its number among the sides of that body
  std::vector<Body> bodies_;
  std::vector<Side> sides_;
  std::vector<double> answers_;       // how rates answer to impulses through each body, 1/kg
  std::vector<double> turned_;        // the same as laws see it
  std::vector<MotionChange> moved_;   // by body
  Eigen::VectorXd impulses_, rates_;  // by row
  // Kept between calls for their memory only.
  std::vector<RowElimination::Sides> row_sides_;
  std::vector<uint8_t> is_chosen_;
  std::vector<double> most_;
  Eigen::VectorXd nearest_;
};

}  // namespace genphys

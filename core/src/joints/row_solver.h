#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "genphys/joint_row.h"
#include "joints/block_kernels.h"
#include "joints/joint_body.h"
#include "joints/row_plan.h"

namespace genphys {

/// Solves the rows of islands that touch nothing, all of an island at once, by block elimination along its graph. Rows
/// with bounds are inside them or at one of them, and which is found in turns with the elimination: all that are wrong
/// change sides at once, or one by one if that leads nowhere (block principal pivoting: Judice and Pires, Computers and
/// Operations Research 21, 1994). The softness of rows makes the equations definite, so that there is one solution.
class RowSolver {
 public:
  /// Solves those of `rows` that `mine` lists, whose sides are at bodies[body_of[row]], and gives the bodies their
  /// velocities and the rows their impulses. A row whose bounds are the same gets that impulse. False, and nothing
  /// done: it would take too long, or the numbers do not suffice. Calls with the same number `plan` had better be about
  /// the same graph.
  bool Solve(uint32_t plan, std::span<JointRow> rows, std::span<const uint32_t> mine, std::span<const uint32_t> body_of,
             std::span<JointBody> bodies);

  /// Once more what the last Solve() did, which was of `plan`: only targets of its rows have changed since, and
  /// `bodies` have the velocities again that they had before.
  bool SolveAgain(uint32_t plan, std::span<JointBody> bodies);

  /// Whether the rows of the last Solve() contradicted each other, so that it only came near.
  bool is_swept() const { return is_swept_; }

  /// The movable bodies of the last Solve(), in `bodies`.
  std::span<const uint32_t> moved() const { return used_; }

 private:
  using Six = Eigen::Matrix<double, 6, 1>;  // linear, then angular

  enum class Place : uint8_t { kInside, kAtLower, kAtUpper };

  struct Line {
    JointRow* row = nullptr;
    std::array<Six, 2> rate;  // per velocity of each side
    std::array<Six, 2> gain;  // velocity of each side per impulse
    double target = 0;        // of the row, m/s or rad/s
    double lacking = 0;       // that less the rate before the solve
    double diagonal = 0;      // rate per impulse, with the softness
    double impulse = 0;
    uint32_t group = 0;
    Place place = Place::kInside;
  };

  void Load(std::span<JointRow> rows, std::span<const uint32_t> mine, std::span<const uint32_t> body_of,
            std::span<const JointBody> bodies);
  static void LoadSides(Line& line, const JointBody& a, const JointBody& b);
  static void LoadPoint(Line* lines, const JointBody& a, const JointBody& b);
  bool IsPoint(size_t first) const;
  uint32_t LocalOf(uint32_t body);
  void CollectInside();
  std::span<const uint32_t> InsideOf(uint32_t group) const {
    return std::span(inside_).subspan(first_inside_[group], first_inside_[group + 1] - first_inside_[group]);
  }
  void Assemble(const RowPlan& plan);
  void AssembleOwn(const RowPlan::Coupling& coupling);
  void AssembleRows(const RowPlan::Coupling& coupling);
  void AssemblePoints(const RowPlan::Coupling& coupling);
  bool Factor(const RowPlan& plan);
  template <size_t kKnown>
  void EliminateFrom(const RowPlan& plan, uint32_t group, RowCount<kKnown> count);
  void FindLacking();
  void Substitute(const RowPlan& plan);
  bool ChangeVelocities();
  size_t FindWrong();
  void Move(Line& line) const;
  double LackingOf(const Line& line) const;
  bool SolveBounded(const RowPlan& plan);
  bool Sweep();
  void Give(std::span<JointBody> bodies) const;

  std::vector<RowPlan> plans_;
  std::vector<Line> lines_;
  bool is_bounded_ = false;  // some row is
  bool is_swept_ = false;
  std::vector<RowPlan::Group> groups_;
  std::vector<uint8_t> is_point_;       // by group: three rows along x, y and z, and no other
  std::vector<uint32_t> inside_;        // lines within their bounds, group by group
  std::vector<uint32_t> first_inside_;  // by group, and one more
  bool is_pushed_ = false;              // some line at a bound has an impulse there
  std::vector<uint32_t> local_of_;      // by body; RowPlan::kStill: not met yet
  std::vector<uint32_t> used_;          // bodies
  std::vector<Six> changes_;            // of velocities, by local number
  std::vector<double> values_;          // blocks of the plan
  std::vector<double> undivided_;       // blocks of one group's links before they are divided by its diagonal
  std::vector<size_t> first_undivided_;
  std::vector<double> solution_;  // as inside_
  std::vector<uint32_t> wrong_;   // lines
};

}  // namespace genphys

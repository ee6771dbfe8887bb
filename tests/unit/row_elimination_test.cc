#include "core/src/contacts/row_elimination.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace genphys {
namespace {

// Of the largest coefficient: the equations are well posed.
constexpr double kRounding = 1e-12;

struct Equations {
  std::mt19937 dice{11};
  std::vector<RowElimination::Sides> rows;
  RowElimination elimination;

  double Any() { return std::uniform_real_distribution(-1.0, 1.0)(dice); }
  uint32_t AnyOf(uint32_t count) { return std::uniform_int_distribution(0u, count - 1)(dice); }

  // Bodies that hang on one before them, and some loops, with one to four rows of each pair in any order.
  void Tie(uint32_t bodies, uint32_t loops) {
    for (uint32_t b = 1; b < bodies; ++b) Add(AnyOf(b), b);
    for (uint32_t i = 0; i < loops; ++i) Add(AnyOf(bodies), AnyOf(bodies));
    for (uint32_t i = 0; i < bodies / 2; ++i) Add(RowPlan::kStill, AnyOf(bodies));
    std::ranges::shuffle(rows, dice);
  }
  void Add(uint32_t a, uint32_t b) {
    if (a == b) return;
    for (uint32_t i = 0; i <= AnyOf(4); ++i)
      rows.push_back(AnyOf(2) ? RowElimination::Sides{a, b} : RowElimination::Sides{b, a});
  }

  bool DoMeet(uint32_t row, uint32_t other) const {
    for (const uint32_t mine : {rows[row].a, rows[row].b}) {
      for (const uint32_t its : {rows[other].a, rows[other].b}) {
        if (mine == its && mine != RowPlan::kStill) return true;
      }
    }
    return row == other;
  }

  // Fills in those that are chosen, and expects what a search for pivots finds.
  void ExpectSolved(std::span<const uint8_t> is_chosen) {
    elimination.Choose(is_chosen);
    const std::span<const uint32_t> order = elimination.order(), numbers = elimination.numbers();
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(elimination.size(), elimination.size());
    for (uint32_t i = 0; i < order.size(); ++i) {
      for (uint32_t j = 0; j < order.size(); ++j) {
        if (!is_chosen[i] || !is_chosen[j] || !DoMeet(order[i], order[j])) continue;
        const double value = Any() + (i == j ? 30 : 0);
        matrix(numbers[i], numbers[j]) = elimination.At(numbers[i], numbers[j]) = value;
      }
    }
    Eigen::VectorXd right(elimination.size());
    for (double& each : right) each = Any();
    const Eigen::VectorXd expected = matrix.partialPivLu().solve(right);
    ASSERT_TRUE(elimination.Factor());
    elimination.Solve(right);
    EXPECT_LE((right - expected).cwiseAbs().maxCoeff(), kRounding);
  }
};

TEST(RowElimination, FindsWhatASearchForPivotsFindsInTreesAndLoops) {
  for (const uint32_t loops : {0u, 3u, 12u}) {
    Equations equations;
    equations.Tie(20, loops);
    ASSERT_TRUE(equations.elimination.Begin(equations.rows, 20));
    equations.ExpectSolved(std::vector<uint8_t>(equations.rows.size(), 1));
  }
}

TEST(RowElimination, LeavesOutWhatIsNotChosenAndTakesItBackIn) {
  Equations equations;
  equations.Tie(15, 4);
  ASSERT_TRUE(equations.elimination.Begin(equations.rows, 15));
  for (int i = 0; i < 20; ++i) {
    std::vector<uint8_t> is_chosen;
    for (size_t row = 0; row < equations.rows.size(); ++row) is_chosen.push_back(equations.AnyOf(2) != 0);
    equations.ExpectSolved(is_chosen);
  }
}

TEST(RowElimination, KeepsRowsBetweenTheSameTwoInTheirOrder) {
  RowElimination elimination;
  const std::vector<RowElimination::Sides> rows{{0, 1}, {2, 1}, {1, 0}, {RowPlan::kStill, 2}, {0, 1}};
  ASSERT_TRUE(elimination.Begin(rows, 3));
  std::vector<uint32_t> between;
  for (const uint32_t row : elimination.order()) {
    if (row == 0 || row == 2 || row == 4) between.push_back(row);
  }
  EXPECT_EQ(between, (std::vector<uint32_t>{0, 2, 4}));
  EXPECT_EQ(elimination.order().size(), rows.size());
}

TEST(RowElimination, RefusesEquationsWithoutASolution) {
  RowElimination elimination;
  ASSERT_TRUE(elimination.Begin(std::vector<RowElimination::Sides>{{0, 1}, {0, 1}}, 2));
  elimination.Choose(std::vector<uint8_t>{1, 1});
  for (const uint32_t row : {0u, 1u}) {
    for (const uint32_t column : {0u, 1u}) elimination.At(row, column) = 1;
  }
  EXPECT_FALSE(elimination.Factor());
}

TEST(RowElimination, RefusesWhatTakesTooLong) {
  RowElimination elimination;
  std::vector<RowElimination::Sides> rows;
  for (uint32_t other = 1; other <= 300; ++other) rows.push_back({0, other});
  EXPECT_TRUE(elimination.Begin(rows, 402));
  for (uint32_t other = 301; other <= 400; ++other) rows.push_back({0, other});
  EXPECT_FALSE(elimination.Begin(rows, 402));
}

}  // namespace
}  // namespace genphys

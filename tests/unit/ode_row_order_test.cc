#include "backends/ode/src/row_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace genphys::ode_backend {
namespace {

uint32_t state = 0;
// Any numbers that differ.
uint32_t Draw() { return state = 1664525 * state + 1013904223; }

// As the library does it after every eighth sweep.
void Shuffle(RowOrder& order, std::vector<size_t>& rows) {
  for (size_t i = 1; i < rows.size(); ++i) {
    const int place = order.PlaceOfLast(static_cast<int>(i + 1));
    ASSERT_GE(place, 0);
    ASSERT_LE(place, static_cast<int>(i));
    std::swap(rows[i], rows[static_cast<size_t>(place)]);
  }
}

std::vector<size_t> Rows(size_t count) {
  std::vector<size_t> rows(count);
  std::iota(rows.begin(), rows.end(), size_t{0});
  return rows;
}

// Of rows in places from `begin` to `end`, how many are among the first `free`.
size_t FreeIn(const std::vector<size_t>& rows, size_t begin, size_t end, size_t free) {
  return static_cast<size_t>(std::count_if(rows.begin() + static_cast<std::ptrdiff_t>(begin),
                                           rows.begin() + static_cast<std::ptrdiff_t>(end),
                                           [&](size_t row) { return row < free; }));
}

TEST(RowOrder, MixesRowsAndLeavesTheLastWordToThoseThatOthersBound) {
  constexpr size_t kFree = 1000, kBounded = 1700;
  RowOrder order;
  order.Begin(kFree, kBounded, 17, Draw);
  std::vector<size_t> rows = Rows(kFree + kBounded);
  Shuffle(order, rows);
  EXPECT_TRUE(std::ranges::is_permutation(rows, Rows(kFree + kBounded)));
  const size_t half = FreeIn(rows, 0, rows.size() / 2, kFree);
  EXPECT_NEAR(static_cast<double>(half), kFree / 2.0, 128);
  EXPECT_NE(rows[0], 0u) << "the first of them are others";
  Shuffle(order, rows);
  EXPECT_TRUE(std::ranges::is_permutation(rows, Rows(kFree + kBounded)));
  EXPECT_EQ(FreeIn(rows, 0, kFree, kFree), kFree);
  EXPECT_FALSE(std::ranges::is_sorted(std::span(rows).first(kFree))) << "or what rests would creep";
}

TEST(RowOrder, GivesNobodyTheLastWordForManySweeps) {
  constexpr size_t kFree = 1000, kBounded = 1000;
  RowOrder order;
  order.Begin(kFree, kBounded, 20, Draw);
  std::vector<size_t> rows = Rows(kFree + kBounded);
  for (int i = 0; i < 2; ++i) {
    Shuffle(order, rows);
    EXPECT_LT(FreeIn(rows, 0, kFree, kFree), kFree * 3 / 4);
  }
}

TEST(RowOrder, LeavesRowsThatItWasNotToldOfWhereTheyAre) {
  RowOrder order;
  order.Begin(3, 2, 17, Draw);
  std::vector<size_t> rows = Rows(9);
  Shuffle(order, rows);
  EXPECT_TRUE(std::ranges::is_permutation(std::span(rows).first(5), Rows(5)));
  EXPECT_EQ(std::vector(rows.begin() + 5, rows.end()), (std::vector<size_t>{5, 6, 7, 8}));
}

TEST(RowOrder, TakesNoRowsAndASingleOne) {
  for (const size_t count : {0, 1, 2}) {
    RowOrder order;
    order.Begin(count, 0, 9, Draw);
    std::vector<size_t> rows = Rows(count);
    Shuffle(order, rows);
    EXPECT_TRUE(std::ranges::is_permutation(rows, Rows(count)));
  }
}

}  // namespace
}  // namespace genphys::ode_backend

#include "genphys/row_set.h"

#include <gtest/gtest.h>

#include <vector>

namespace genphys {
namespace {

std::vector<uint32_t> RowsOf(const RowSet& set) {
  std::vector<uint32_t> rows;
  set.ForEach([&](uint32_t row) { rows.push_back(row); });
  return rows;
}

TEST(RowSet, HasWhatWasAddedAndNotRemoved) {
  RowSet set;
  for (const uint32_t row : {200u, 0u, 63u, 64u, 127u, 63u}) set.Add(row);

  set.Remove(64);
  set.Remove(65);
  set.Remove(100000);

  EXPECT_EQ(RowsOf(set), (std::vector<uint32_t>{0, 63, 127, 200}));
  EXPECT_TRUE(set[63]);
  EXPECT_FALSE(set[64]);
  EXPECT_FALSE(set[201]);
  EXPECT_FALSE(set[100000]);
}

TEST(RowSet, IsTheUnionOfWhatWasAdded) {
  RowSet some, others;
  some.Add(3);
  others.Add(3);
  others.Add(200);

  some.Add(others);
  some.Add(RowSet());

  EXPECT_EQ(RowsOf(some), (std::vector<uint32_t>{3, 200}));
}

TEST(RowSet, HasAllBelowANumberAndNoneAbove) {
  for (const uint32_t rows : {0u, 1u, 63u, 64u, 65u, 128u}) {
    RowSet set;
    set.Add(130);

    set.AddAll(rows);

    std::vector<uint32_t> wanted;
    for (uint32_t row = 0; row < rows; ++row) wanted.push_back(row);
    wanted.push_back(130);
    EXPECT_EQ(RowsOf(set), wanted);
  }
}

TEST(RowSet, VisitsThoseThatAreInBoth) {
  RowSet some, others;
  for (const uint32_t row : {1u, 70u, 300u}) some.Add(row);
  for (const uint32_t row : {1u, 71u, 70u, 90u}) others.Add(row);
  std::vector<uint32_t> both, reverse;

  RowSet::ForEachOfBoth(some, others, [&](uint32_t row) { both.push_back(row); });
  RowSet::ForEachOfBoth(others, some, [&](uint32_t row) { reverse.push_back(row); });

  EXPECT_EQ(both, (std::vector<uint32_t>{1, 70}));
  EXPECT_EQ(reverse, both);
}

}  // namespace
}  // namespace genphys

#include "core/src/impacts/pair_places.h"

#include <gtest/gtest.h>

#include <vector>

namespace genphys {
namespace {

struct Entry {
  ContactPair pair;
  int name = 0;
};

Entry Of(uint32_t a, uint32_t b, int name) {
  return {{.geometry_a = GeometryRow{a}, .geometry_b = GeometryRow{b}}, name};
}

// Few are looked through, and of many there is an index.
class PairPlacesTest : public ::testing::TestWithParam<uint32_t> {
 protected:
  PairPlacesTest() {
    for (uint32_t i = 0; i < GetParam(); ++i) list_.push_back(Of(100 + i, 200 + i, 0));
  }

  PairPlaces places_;
  std::vector<Entry> list_;
};
INSTANTIATE_TEST_SUITE_P(Others, PairPlacesTest, ::testing::Values(0, 40));

TEST_P(PairPlacesTest, AreFoundOfAllThatCameAndTheFirstOfThose) {
  list_.push_back(Of(1, 2, 10));
  list_.push_back(Of(2, 1, 11));
  EXPECT_EQ(places_.Find(list_, GeometryRow{1}, GeometryRow{2})->name, 10);
  EXPECT_EQ(places_.Find(list_, GeometryRow{2}, GeometryRow{1})->name, 11);
  EXPECT_EQ(places_.Find(list_, GeometryRow{1}, GeometryRow{3}), nullptr);
  list_.push_back(Of(1, 3, 12));
  list_.push_back(Of(1, 2, 13));
  EXPECT_EQ(places_.Find(list_, GeometryRow{1}, GeometryRow{3})->name, 12);
  EXPECT_EQ(places_.Find(list_, GeometryRow{1}, GeometryRow{2})->name, 10);
}

TEST_P(PairPlacesTest, AreThoseOfTheListAsItIsOnceTheOldOnesAreForgotten) {
  list_.push_back(Of(1, 2, 10));
  list_.push_back(Of(3, 4, 11));
  ASSERT_NE(places_.Find(list_, GeometryRow{1}, GeometryRow{2}), nullptr);
  list_.erase(list_.end() - 2);
  places_.Forget();
  EXPECT_EQ(places_.Find(list_, GeometryRow{1}, GeometryRow{2}), nullptr);
  EXPECT_EQ(places_.Find(list_, GeometryRow{3}, GeometryRow{4})->name, 11);
}

}  // namespace
}  // namespace genphys

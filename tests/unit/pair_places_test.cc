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

TEST(PairPlaces, AreFoundOfAllThatCameAndTheFirstOfThose) {
  PairPlaces places;
  std::vector<Entry> list{Of(1, 2, 10), Of(2, 1, 11)};
  EXPECT_EQ(places.Find(list, GeometryRow{1}, GeometryRow{2})->name, 10);
  EXPECT_EQ(places.Find(list, GeometryRow{2}, GeometryRow{1})->name, 11);
  EXPECT_EQ(places.Find(list, GeometryRow{1}, GeometryRow{3}), nullptr);
  list.push_back(Of(1, 3, 12));
  list.push_back(Of(1, 2, 13));
  EXPECT_EQ(places.Find(list, GeometryRow{1}, GeometryRow{3})->name, 12);
  EXPECT_EQ(places.Find(list, GeometryRow{1}, GeometryRow{2})->name, 10);
}

TEST(PairPlaces, AreThoseOfTheListAsItIsOnceTheOldOnesAreForgotten) {
  PairPlaces places;
  std::vector<Entry> list{Of(1, 2, 10), Of(3, 4, 11)};
  ASSERT_NE(places.Find(list, GeometryRow{1}, GeometryRow{2}), nullptr);
  list.erase(list.begin());
  places.Forget();
  EXPECT_EQ(places.Find(list, GeometryRow{1}, GeometryRow{2}), nullptr);
  EXPECT_EQ(places.Find(list, GeometryRow{3}, GeometryRow{4})->name, 11);
}

}  // namespace
}  // namespace genphys

#include "genphys/islands.h"

#include <gtest/gtest.h>

#include <array>

namespace genphys {
namespace {

// Two bodies that a joint holds together, and a third one that a gap of the second one parts from, or closes.
ContactBuffer GapBetween(EntityRow a, EntityRow b, double closing, bool is_ahead) {
  ContactBuffer contacts;
  contacts.points.push_back({.depth = -1e-3, .relative_velocity = {0, 0, -closing}, .is_ahead = is_ahead});
  contacts.pairs.push_back({.entity_a = a, .entity_b = b, .point_count = 1});
  return contacts;
}

constexpr std::array kBodies = {EntityRow{0}, EntityRow{1}, EntityRow{2}};

Islands IslandsOf(const ContactBuffer& contacts) {
  const std::array rows = {JointRow{.a = kBodies[0], .b = kBodies[1]}};
  Islands islands;
  islands.Find(3, kBodies, contacts, rows);
  return islands;
}

TEST(Islands, CountAContactThatHolds) {
  const Islands islands = IslandsOf(GapBetween(kBodies[1], kBodies[2], 1, false));
  ASSERT_EQ(islands.islands().size(), 1u);
  EXPECT_EQ(islands.IslandOf(kBodies[2]), 0u);
  EXPECT_EQ(islands.islands()[0].contacts, 1u);
  EXPECT_EQ(islands.islands()[0].joint_rows, 1u);
}

TEST(Islands, CountWhatComesToMeetThemThoughItIsNotHeldYet) {
  const Islands islands = IslandsOf(GapBetween(kBodies[1], kBodies[2], 1, true));
  EXPECT_EQ(islands.IslandOf(kBodies[2]), Islands::kNone);
  EXPECT_EQ(islands.islands()[0].contacts, 1u);
}

TEST(Islands, AreNotTouchedByWhatParts) {
  const Islands islands = IslandsOf(GapBetween(kBodies[1], kBodies[2], -1, true));
  EXPECT_EQ(islands.IslandOf(kBodies[2]), Islands::kNone);
  EXPECT_EQ(islands.islands()[0].contacts, 0u);
}

TEST(Islands, AreNotTouchedBySensors) {
  ContactBuffer contacts = GapBetween(kBodies[1], kBodies[2], 1, false);
  contacts.pairs[0].is_sensor = true;
  const Islands islands = IslandsOf(contacts);
  EXPECT_EQ(islands.IslandOf(kBodies[2]), Islands::kNone);
  EXPECT_EQ(islands.islands()[0].contacts, 0u);
}

}  // namespace
}  // namespace genphys

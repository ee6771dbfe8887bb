#include "genphys/joint_memory.h"

#include <gtest/gtest.h>

namespace genphys {
namespace {

EntityId IdOf(EntityRow row) { return EntityId(Index(row), 1); }

JointRow Row(uint32_t a, uint32_t b, double lower, double upper, double impulse = 0) {
  return {.a = EntityRow{a}, .b = EntityRow{b}, .lower = lower, .upper = upper, .impulse = impulse};
}

TEST(JointMemory, HasRowsStartFromWhatThoseLikeThemCameTo) {
  JointMemory memory;
  const std::vector<JointRow> solved{Row(0, 1, -2, 2, 1.5), Row(0, 1, -2, 2, -0.5), Row(1, 2, 0, INFINITY, 3),
                                     Row(2, 3, -INFINITY, INFINITY, 7)};
  memory.Note(solved, IdOf);
  // Others lie between, bounds are others, and one is of another kind.
  std::vector<JointRow> rows{Row(1, 2, 0, INFINITY), Row(5, 6, -1, 1), Row(0, 1, -9, 9),
                             Row(0, 1, -9, 9),       Row(1, 2, -1, 1), Row(2, 3, -INFINITY, INFINITY)};
  memory.Recall(rows, IdOf);
  const double expected[] = {3, 0, 1.5, -0.5, 0, 7};
  for (size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(rows[i].impulse, expected[i]) << i;
}

TEST(JointMemory, ForgetsWhoIsRemovedAndWhatWasBeforeTheLastSolve) {
  JointMemory memory;
  memory.Note(std::vector<JointRow>{Row(0, 1, -2, 2, 1), Row(2, 3, -2, 2, 1)}, IdOf);
  memory.Remove(IdOf(EntityRow{1}));
  std::vector<JointRow> rows{Row(0, 1, -2, 2, 8), Row(2, 3, -2, 2, 8)};
  memory.Recall(rows, IdOf);
  EXPECT_EQ(rows[0].impulse, 0);
  EXPECT_EQ(rows[1].impulse, 1);
  memory.Note(std::vector<JointRow>{}, IdOf);
  memory.Recall(rows, IdOf);
  EXPECT_EQ(rows[1].impulse, 0);
}

TEST(JointMemory, IsSavedAsItIs) {
  const auto saved = [](const JointMemory& memory) {
    std::string bytes;
    memory.Save(bytes);
    return bytes;
  };
  JointMemory one, same, other;
  one.Note(std::vector<JointRow>{Row(0, 1, -2, 2, 1)}, IdOf);
  same.Note(std::vector<JointRow>{Row(0, 1, -2, 2, 1)}, IdOf);
  other.Note(std::vector<JointRow>{Row(0, 1, -2, 2, 1.25)}, IdOf);
  EXPECT_EQ(saved(one), saved(same));
  EXPECT_NE(saved(one), saved(other));
  EXPECT_NE(saved(one), saved(JointMemory()));
}

}  // namespace
}  // namespace genphys

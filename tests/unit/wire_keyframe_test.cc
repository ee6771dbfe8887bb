#include "genphys/wire/keyframe.h"

#include <gtest/gtest.h>

#include <vector>

namespace genphys {
namespace {

StateArrays State(uint32_t rows) {
  StateArrays state;
  state.Resize(rows);
  for (uint32_t row = 0; row < rows; ++row) state.ids[row] = EntityId(row, 1);
  return state;
}

v1::FrameRequest Poses() {
  v1::FrameRequest request;
  request.set_poses(true);
  return request;
}

RowSet All(uint32_t rows) {
  RowSet set;
  set.AddAll(rows);
  return set;
}

TEST(Keyframe, TellsRowsThatDifferInAColumnThatIsWanted) {
  StateArrays state = State(100);
  Keyframe keyframe(state, Poses(), 1, 0);
  keyframe.MayDiffer(All(100));
  EXPECT_EQ(keyframe.Differing(state), std::vector<uint32_t>());

  state.positions(2, 7) = 1e-300;
  state.orientations(0, 70) = -state.orientations(0, 70);
  state.asleep[99] = 1;
  state.linear_velocities(0, 50) = 3;

  EXPECT_EQ(keyframe.Differing(state), (std::vector<uint32_t>{7, 70, 99}));
}

TEST(Keyframe, LooksOnlyAtWhatMayDiffer) {
  StateArrays state = State(100);
  Keyframe keyframe(state, Poses(), 1, 0);
  state.positions.setConstant(5);
  RowSet some;
  some.Add(4);
  some.Add(80);

  keyframe.MayDiffer(some);

  EXPECT_EQ(keyframe.Differing(state), (std::vector<uint32_t>{4, 80}));
}

TEST(Keyframe, TellsOnlyRowsOfItsFrameInOrderOfTheirIds) {
  StateArrays state = State(10);
  state.ids[2] = EntityId(2, 9);  // came last
  v1::FrameRequest some = Poses();
  for (const uint32_t row : {2u, 3u, 5u}) some.add_entity_ids(state.ids[row].packed());
  Keyframe keyframe(state, some, 1, 0), whole(state, Poses(), 2, 0);
  keyframe.MayDiffer(All(10));
  whole.MayDiffer(All(10));

  state.positions.setConstant(5);

  EXPECT_EQ(keyframe.Differing(state), (std::vector<uint32_t>{3, 5, 2}));
  EXPECT_EQ(whole.Differing(state).back(), 2u);
}

TEST(Keyframe, KnowsWhenEntitiesCameOrWent) {
  StateArrays state = State(10);
  v1::FrameRequest some = Poses();
  some.add_entity_ids(state.ids[3].packed());
  const Keyframe whole(state, Poses(), 1, 0), one(state, some, 2, 0);
  EXPECT_TRUE(whole.HasRowsOf(state, Poses()));

  state.ids[5] = EntityId();

  EXPECT_FALSE(whole.HasRowsOf(state, Poses()));
  EXPECT_TRUE(one.HasRowsOf(state, some));
  state.ids[3] = EntityId(3, 2);
  EXPECT_FALSE(one.HasRowsOf(state, some));
}

}  // namespace
}  // namespace genphys

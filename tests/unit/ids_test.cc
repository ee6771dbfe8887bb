#include "genphys/ids.h"

#include <gtest/gtest.h>

#include <limits>

#include "genphys/layer_state.h"

namespace genphys {
namespace {

TEST(Ids, ZeroIsNull) {
  EXPECT_TRUE(EntityId().is_null());
  EXPECT_TRUE(EntityId::FromPacked(0).is_null());
  EXPECT_FALSE(EntityId(0, 0).is_null());
}

TEST(Ids, ThePackedFormBringsBackSlotAndGeneration) {
  const EntityId id(7, 3);

  const EntityId copy = EntityId::FromPacked(id.packed());

  EXPECT_EQ(copy, id);
  EXPECT_EQ(copy.index(), 7u);
  EXPECT_EQ(copy.generation(), 3u);
}

TEST(Ids, AForgedIdWithoutASlotNamesTheLastOneThatCanNotExist) {
  EXPECT_EQ(EntityId::FromPacked(uint64_t{1} << 32).index(), std::numeric_limits<uint32_t>::max());
}

TEST(IdAllocator, TakesTheLowestFreeSlotWithANewGeneration) {
  IdAllocator ids;
  const EntityId first = ids.Allocate<EntityTag>(), second = ids.Allocate<EntityTag>(),
                 third = ids.Allocate<EntityTag>();
  ids.Free(third);
  ids.Free(first);

  const EntityId again = ids.Allocate<EntityTag>();

  EXPECT_EQ(again.index(), first.index());
  EXPECT_NE(again, first);
  EXPECT_NE(again, second);
}

TEST(IdAllocator, RetiresASlotWhoseGenerationsAreUsedUp) {
  IdAllocator ids;
  const EntityId first = ids.Allocate<EntityTag>();
  ids.generations[first.index()] = std::numeric_limits<uint32_t>::max() - 1;

  ids.Free(EntityId(first.index(), std::numeric_limits<uint32_t>::max() - 1));

  EXPECT_NE(ids.Allocate<EntityTag>().index(), first.index());
}

}  // namespace
}  // namespace genphys

// What hundreds of bodies bear up together stands still.
#include <vector>

#include "engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Pyramids, Claim::kStaticFriction);

constexpr int kRow = 20;
constexpr double kSpacing = 1.02;   // m
constexpr int kStepsBefore = 120;   // until it has settled
constexpr double kCreepMax = 2e-4;  // m in the mean, in as many steps more; 4e-5 are left of their settling

TEST_P(Pyramids, OfHundredsOfBoxesDoNotCreep) {
  WorldDesc desc{.engine = GetParam()};
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  std::vector<EntityId> boxes;
  for (int layer = 0; layer < kRow; ++layer) {
    for (int i = 0; i < kRow - layer; ++i)
      boxes.push_back(Add(*world, Crate({kSpacing * (i + 0.5 * layer), 0, 0.5 + layer})));
  }
  Steps(*world, kStepsBefore);
  std::vector<Vector3> before;
  for (const EntityId box : boxes) before.push_back(PositionOf(*world, box));
  Steps(*world, kStepsBefore);
  double sum = 0;
  for (size_t i = 0; i < boxes.size(); ++i) sum += (PositionOf(*world, boxes[i]) - before[i]).norm();
  EXPECT_LT(sum / static_cast<double>(boxes.size()), kCreepMax);
}

}  // namespace
}  // namespace genphys::testing

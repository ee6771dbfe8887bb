// A sample of what tests/stress does for hours.
#include <gtest/gtest.h>

#include "support/endurance.h"
#include "support/scenes.h"

namespace genphys::testing {
namespace {

class Endurance : public ::testing::TestWithParam<std::string> {};

TEST_P(Endurance, WildWorldsStayFiniteAndReplayBitByBit) { ExpectWildWorldsToReplay(GetParam(), 40); }

TEST_P(Endurance, FallingBodiesGainNoEnergy) {
  constexpr uint64_t kWorlds = 40;
  for (uint64_t seed = 1; seed <= kWorlds; ++seed) ExpectNoEnergyFromNowhere(GetParam(), seed);
}

TEST_P(Endurance, APenOfKickedBodiesLasts) { ExpectPenToLast(GetParam(), 1500); }

INSTANTIATE_TEST_SUITE_P(Engines, Endurance, ::testing::ValuesIn(EnginesWithContacts()),
                         [](const auto& engine) { return engine.param; });

}  // namespace
}  // namespace genphys::testing

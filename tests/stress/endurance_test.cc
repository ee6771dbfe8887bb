#include "support/endurance.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace genphys::testing {
namespace {

class Stress : public ::testing::TestWithParam<std::string> {};

TEST_P(Stress, TenThousandWildWorldsStayFiniteAndReplayBitByBit) { ExpectWildWorldsToReplay(GetParam(), 10'000); }

TEST_P(Stress, FallingBodiesGainNoEnergy) {
  constexpr uint64_t kWorlds = 5000;
  for (uint64_t seed = 1; seed <= kWorlds; ++seed) ExpectNoEnergyFromNowhere(GetParam(), seed);
}

TEST_P(Stress, APenOfKickedBodiesLastsAMillionSteps) { ExpectPenToLast(GetParam(), 1'000'000); }

INSTANTIATE_TEST_SUITE_P(Engines, Stress, ::testing::ValuesIn(EnginesWithContacts()),
                         [](const auto& engine) { return engine.param; });

}  // namespace
}  // namespace genphys::testing

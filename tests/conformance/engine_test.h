#pragma once
#include <gtest/gtest.h>

#include <string>

#include "support/scenes.h"

namespace genphys::testing {

/// A test that every engine with contacts has to pass: written once, run once per engine.
class EngineTest : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<World> MakeWorld() const { return testing::MakeWorld(GetParam()); }
};

inline std::string EngineName(const ::testing::TestParamInfo<std::string>& info) { return info.param; }

}  // namespace genphys::testing

/// Names the concept of the file and runs its tests on every engine.
#define GENPHYS_ENGINE_TESTS(Concept)                                                                        \
  class Concept : public ::genphys::testing::EngineTest {};                                                  \
  INSTANTIATE_TEST_SUITE_P(Engines, Concept, ::testing::ValuesIn(::genphys::testing::EnginesWithContacts()), \
                           ::genphys::testing::EngineName)

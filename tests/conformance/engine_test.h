#pragma once
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <tuple>
#include <type_traits>

#include "support/claims.h"
#include "support/scenes.h"
#include "support/tolerances.h"

namespace genphys::testing {

/// A test that every engine has to pass: written once, run once per engine. One that asks an engine for something that
/// this refuses by name ends there and has passed: the refusal was looked at (see EndAtRefusal()).
template <typename Param>
class EveryEngineTest : public ::testing::TestWithParam<Param> {
 protected:
  void SetUp() override {
    if constexpr (std::is_same_v<Param, std::string>) {
      EndAtRefusalsOf(this->GetParam());
    } else {
      EndAtRefusalsOf(std::get<0>(this->GetParam()));
    }
  }

  void TearDown() override {
    EndAtRefusalsOf("");
    std::string names;
    for (const Claim claim : claims_) names += NameOf(claim) + '|';
    this->RecordProperty("proves", names);
    this->RecordProperty("refused", TakeRefused());
  }

  /// What this test is about, besides what its suite says.
  void Proves(std::initializer_list<Claim> claims) { claims_.insert(claims_.end(), claims.begin(), claims.end()); }

 private:
  std::vector<Claim> claims_;
};

class EngineTest : public EveryEngineTest<std::string> {
 protected:
  std::unique_ptr<World> MakeWorld() const { return testing::MakeWorld(GetParam()); }
};

inline std::string EngineName(const ::testing::TestParamInfo<std::string>& info) { return info.param; }

}  // namespace genphys::testing

/// Names the concept of the file, what all of its tests prove, and runs them on every engine.
#define GENPHYS_ENGINE_TESTS(Concept, ...)                                                               \
  class Concept : public ::genphys::testing::EngineTest {                                                \
    void SetUp() override {                                                                              \
      EngineTest::SetUp();                                                                               \
      Proves({__VA_ARGS__});                                                                             \
    }                                                                                                    \
  };                                                                                                     \
  INSTANTIATE_TEST_SUITE_P(Engines, Concept, ::testing::ValuesIn(::genphys::testing::EveryEngineName()), \
                           ::genphys::testing::EngineName)

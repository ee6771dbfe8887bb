// Many fields at the ends of their limits at once, in one batch and in one body: the state stays finite.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "conformance/engine_test.h"
#include "integration/input_bench.h"
#include "integration/meaning.h"
#include "support/limit_cases.h"
#include "support/requests.h"
#include "support/sweep.h"

namespace genphys::testing {
namespace {

constexpr int kBatches = 300 / kSweepStride;
constexpr size_t kCommands = 5;  // in each batch
constexpr size_t kExtremes = 4;  // at most, in each body

const google::protobuf::MethodDescriptor& StepMethod() {
  return *v1::StepRequest::descriptor()->file()->FindServiceByName("SimulationService")->FindMethodByName("Step");
}

class LiveExtremes : public EngineTest {
 protected:
  // Commands with one field each at an end of its limits, by kind.
  void Collect() {
    const auto sample = MinimalRequest(v1::StepRequest::descriptor());
    const LimitCaseOptions options{.field_bytes_max = 1000,
                                   .complete = [&](google::protobuf::Message& added) { bench_.Complete(added); }};
    Meaning meaning(GetParam());
    ForEachLimitCase(*sample, options, [&](const LimitCase& probe) {
      const auto& request = static_cast<const v1::StepRequest&>(probe.request);
      if (probe.refusal || meaning.RefusalFor(probe) || request.commands_size() != 1) return;
      commands_.push_back(request.commands(0));
    });
  }

  const v1::Command& Any() {
    return commands_[std::uniform_int_distribution<size_t>(0, commands_.size() - 1)(random_)];
  }

  // A command of any kind; when it describes an entity, with several extremes.
  v1::Command Next() {
    v1::Command command = Any();
    const size_t merged = std::uniform_int_distribution<size_t>(0, kExtremes - 1)(random_);
    for (size_t i = 0; i < merged;) {
      const v1::Command& other = Any();
      if (!other.has_create_entity()) continue;
      ++i;
      if (command.has_create_entity()) {
        command.mutable_create_entity()->mutable_entity()->MergeFrom(other.create_entity().entity());
      }
    }
    return command;
  }

  InputBench bench_{GetParam()};
  std::mt19937_64 random_{1};
  std::vector<v1::Command> commands_;
};

INSTANTIATE_TEST_SUITE_P(Engines, LiveExtremes, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

TEST_P(LiveExtremes, OfManyFieldsAtOnceKeepTheStateFinite) {
  Collect();
  int accepted = 0;

  for (int i = 0; i < kBatches; ++i) {
    v1::StepRequest request;
    request.set_world("worlds/a");
    for (size_t c = 0; c < kCommands; ++c) *request.add_commands() = Next();
    accepted += bench_.TryEither(StepMethod(), request, request.ShortDebugString()) ? 1 : 0;
  }

  EXPECT_GT(accepted, kBatches / 2) << "the rest are refused, for one thing that excludes another";
}

TEST_P(LiveExtremes, OfNearnessPartTwoBodiesOfAnyShapes) {
  const std::vector<std::string> shapes{"sphere", "box", "capsule", "cylinder"};
  const auto body = [](const std::string& shape, const std::string& z) {
    return "commands { create_entity { entity { pose { position { x: 10 z: " + z +
           " } } rigid_body { geometries { shape { " + shape + " {} } } } } } }";
  };

  for (const std::string& a : shapes) {
    for (const std::string& b : shapes) {
      // With one centre, and with centres on one axis.
      for (const char* z : {"1", "1.1", "1.5", "2"}) bench_.TryStep(body(a, "1") + body(b, z), "accepted");
    }
  }
}

// A call has half a minute. Each took more than that while a way was followed however often the body turns on it.
TEST_P(LiveExtremes, OfReachAndSpinAreSweptInTimeForTheCall) {
  bench_.TryStep(R"(
    commands { create_entity { entity { rigid_body {
      geometries { shape { sphere {} } }
      geometries { shape { sphere {} } surface_velocity { x: 1 y: 1 z: 1e5 } }
      geometries { shape { sphere {} } pose_in_entity { position { x: 1e7 y: 1 z: 1 } } }
      linear_velocity { x: 1 y: -1e5 z: 1 } } } } }
    commands { update_joint { joint { id: 1 entity_b { id: 4 }
      six_dof { about_x { spring { rest_radians: -10000 } } } } } }
    commands { create_joint { joint { entity_b { id: 4 } slider { motor { target_velocity: -99999 } } } } }
    commands { update_force_field { field { id: 1 spring { entity_a: 4 point_in_a { x: 1 y: 1e7 z: 1 } } } } }
    commands { create_joint { joint { entity_b { id: 4 }
      six_dof { about_z { limits { upper_radians: -10000 } } } } } })",
                 "accepted");
  bench_.TryStep(R"(
    commands { update_entity { entity { id: 4 rigid_body {
      geometries { shape { ellipsoid { semi_axes { x: 1e5 y: 1 z: 1 } } } } } } } }
    commands { apply_impulse { entity_id: 4 angular { x: -1e12 y: 1 z: 1 } } })",
                 "accepted");
}

TEST_P(LiveExtremes, OfFormAndPlaceMakeABodyThatTurns) {
  const std::vector<std::string> shapes{"sphere { radius: 1e-5 }", "box { half_extents { x: 1e-5 y: 1e5 z: 1e-5 } }",
                                        "cylinder { radius: 1e-5 half_length: 1e5 }",
                                        "capsule { radius: 1e5 half_length: 1e-5 }"};
  const std::vector<std::string> poses{"", "pose_in_entity { position { x: 1e7 y: -1e7 z: 3e6 } }",
                                       "pose_in_entity { orientation { w: 0.6 y: 0.8 } }"};
  const std::vector<std::string> inertias{"", "inertia { mass: 1e-9 }",
                                          "inertia { mass: 1e9 center_of_mass { x: 1e5 y: 1e5 } }"};

  for (const std::string& shape : shapes) {
    for (const std::string& pose : poses) {
      for (const std::string& inertia : inertias) {
        bench_.TryStep("commands { create_entity { entity { pose { position { z: 50 } } rigid_body { " + inertia +
                           " angular_velocity { x: 1e4 y: 1 z: 1e4 } geometries { " + pose + " shape { " + shape +
                           " } } } } } }",
                       "accepted");
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

// The statistics of a step count everybody once, and what was done in that step.
#include <gtest/gtest.h>

#include <string>

#include "conformance/engine_test.h"
#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;

class StepStatistics : public EngineTest {
 protected:
  // Boxes that stand apart, each on its own place of the floor.
  StepStatistics() {
    v1::World world;
    world.set_engine("engines/" + GetParam());
    request_.set_world(server_.CreateWorld(world).world().name());
    request_.set_stats(true);
    v1::StepRequest boxes = request_;
    boxes.set_steps(0);
    for (uint32_t i = 0; i < kBoxes; ++i) {
      v1::Entity& box = *boxes.add_commands()->mutable_create_entity()->mutable_entity();
      v1::Vector3& half =
          *box.mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_box()->mutable_half_extents();
      half.set_x(0.5), half.set_y(0.5), half.set_z(0.5);
      box.mutable_pose()->mutable_position()->set_x(3 * i);
      box.mutable_pose()->mutable_position()->set_z(0.5);
    }
    Must(server_.simulation(), &Simulation::Step, boxes);
  }

  v1::StepStats Next() { return Must(server_.simulation(), &Simulation::Step, request_).stats(); }

  static constexpr uint32_t kBoxes = 5;
  TestServer server_;
  v1::StepRequest request_;
};

INSTANTIATE_TEST_SUITE_P(Engines, StepStatistics, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

TEST_P(StepStatistics, CountWhoFallsAsleepInTheLaneThatItWasIn) {
  constexpr int kStepsMax = 300;
  v1::StepStats stats;
  for (int i = 0; i < kStepsMax && stats.entities_asleep() < kBoxes; ++i) {
    stats = Next();
    EXPECT_EQ(stats.entities_asleep() + stats.entities_in_flight() + stats.entities_in_engine(), kBoxes)
        << "step " << i;
  }
  EXPECT_EQ(stats.entities_asleep(), kBoxes) << "they do not sleep";
}

TEST_P(StepStatistics, FindNoContactsInAStepThatLooksForNone) {
  EXPECT_GE(Next().contacts(), kBoxes);
  constexpr uint32_t kLong = 300;
  v1::StepRequest long_request = request_;
  long_request.set_steps(kLong);

  const v1::StepStats idle = Must(server_.simulation(), &Simulation::Step, long_request).stats();

  EXPECT_EQ(idle.entities_asleep(), kBoxes);
  EXPECT_EQ(idle.pairs_tested(), 0u);
  EXPECT_EQ(idle.contacts(), 0u);
  EXPECT_EQ(idle.islands(), 0u);
}

}  // namespace
}  // namespace genphys::testing

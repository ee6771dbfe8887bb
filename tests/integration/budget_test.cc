// A step that takes too much, as a client meets it: told by name, undone, and nothing to be afraid of.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "conformance/engine_test.h"
#include "genphys/limits.h"
#include "integration/live_server.h"

namespace genphys::testing {
namespace {

class BudgetOverTheWire : public EngineTest {};

INSTANTIATE_TEST_SUITE_P(Engines, BudgetOverTheWire, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

// A square of sensors and as many bodies that ignore each other, which fly to its middle: nothing bounces off on the
// way, but each body is near every sensor there, in the third step. The two before are the cheapest that there are: who
// comes slower has steps with nearly as many pairs first, and sanitizers make minutes of them.
std::vector<Command> Swarm() {
  constexpr double kApproachRate = 20;  // 1/s
  const auto side = static_cast<int>(std::ceil(std::sqrt(2 * std::sqrt(1.25 * Limits::kNearPairsMax))));
  std::vector<Command> commands{SetGravity{Vector3::Zero()}};
  for (int i = 0; i < side * side; ++i) {
    const Vector3 from_middle{1.5 * (i % side - side / 2), 1.5 * (i / side - side / 2), 0};
    EntityDesc ghost = Ball(from_middle + Vector3{0, 0, 100}, 0.5);
    Geometry& geometry = ghost.rigid_body->geometries[0];
    geometry.is_sensor = i % 2 == 0;
    if (!geometry.is_sensor) geometry.collision_space = "swarm";
    ghost.rigid_body->inertia.mass = 1;
    ghost.rigid_body->inertia.tensor = Matrix3::Identity();
    ghost.rigid_body->linear_velocity = -kApproachRate * from_middle;
    commands.push_back(CreateEntity{ghost});
  }
  return commands;
}

TEST_P(BudgetOverTheWire, AStepOverItIsRefusedByNameAndTheWorldGoesOn) {
  const LiveServer live;
  client::Server server = live.Connect();
  client::World world = Value(server.CreateWorld(WorldOn(GetParam())));
  const std::vector<CreatedId> ids = Value(world.Apply(Swarm()));

  const Status status = world.Step(20, {.deadline = std::chrono::minutes(5)}).status();

  const uint64_t step = Value(world.Info()).stamp.step;
  ASSERT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(RefusalOf(status).value_or(Refusal{}).reason, Reason::kBudgetExceeded);
  EXPECT_NE(MessageOf(status).find("pairs of geometries are near each other"), std::string::npos) << status;
  EXPECT_NE(MessageOf(status).find(std::to_string(step) + " of 20 steps"), std::string::npos) << status;
  EXPECT_GT(step, 0u);
  EXPECT_EQ(EarlyEndOf(status), (EarlyEnd{static_cast<uint32_t>(step), step}));
  EXPECT_EQ(Value(world.Info()).state, client::WorldInfo::State::kPaused);

  std::vector<Command> removal;
  for (size_t i = 100; i < ids.size(); ++i) removal.push_back(DeleteEntity{ids[i]});
  MustBeOk(world.Apply(removal).status());
  EXPECT_EQ(Value(world.Step(10)).stamp.step, step + 10);
}

}  // namespace
}  // namespace genphys::testing

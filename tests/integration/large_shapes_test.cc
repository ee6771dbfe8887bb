// The largest shapes that the contract allows keep one world busy, and no other.
#include <atomic>
#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include "conformance/engine_test.h"
#include "integration/live_server.h"
#include "support/shapes.h"
#include "support/sweep.h"

namespace genphys::testing {
namespace {

using Clock = std::chrono::steady_clock;

class LargeShapes : public EngineTest {};

INSTANTIATE_TEST_SUITE_P(Engines, LargeShapes, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

// Steps a world of its own until it is told to stop.
class Neighbour {
 public:
  Neighbour(const client::Server& server, const std::string& engine)
      : world_(Value(server.CreateWorld(WorldOn(engine)))), thread_([this] { Run(); }) {}
  ~Neighbour() {
    stop_ = true;
    thread_.join();
  }

  int steps() const { return steps_; }

 private:
  void Run() {
    while (!stop_) {
      if (!world_.Step(1).ok()) return;
      ++steps_;
    }
  }

  client::World world_;
  std::atomic<bool> stop_ = false;
  std::atomic<int> steps_ = 0;
  std::thread thread_;
};

TEST_P(LargeShapes, OfAMillionTrianglesLetOtherWorldsGoOn) {
  const LiveServer live;
  const client::Server server = live.Connect();
  const TriangleMesh mesh =
      GroundMesh(100, kManyCells, [](double x, double y) { return 0.3 * std::sin(x) * std::cos(y); });
  client::World world = Value(server.CreateWorld(WorldOn(GetParam())));
  const Neighbour neighbour(server, GetParam());
  const int before = neighbour.steps();
  const auto start = Clock::now();

  Value(world.Add(mesh, {.position = {0, 0, 5}, .motion_type = MotionType::kStatic}));

  RecordProperty("seconds", std::to_string(std::chrono::duration<double>(Clock::now() - start).count()));
  // It takes seconds, in which an undisturbed world makes thousands of steps.
  EXPECT_GT(neighbour.steps() - before, 100);
  // On the top of a wave, where it would roll down if there were anything to push it.
  const EntityId ball = Value(world.Add(Box{{0.3, 0.3, 0.3}}, {.position = {M_PI / 2, 0, 5.7}, .mass = 1}));
  const client::StepResult result = Value(world.Step(60));
  EXPECT_NEAR(PositionIn(result.frame, ball).z(), 5.6, 0.05);
}

TEST_P(LargeShapes, OfAHundredThousandPointsLetOtherWorldsGoOn) {
  const LiveServer live;
  const client::Server server = live.Connect();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Vector3> points;
  for (int i = 0; i < (kSweepStride == 1 ? 100'000 : 20'000); ++i) {
    points.push_back(0.5 * Vector3(normal(random), normal(random), normal(random)).normalized());
  }
  const ConvexHull hull = Value(MakeConvexHull(points));
  client::World world = Value(server.CreateWorld(WorldOn(GetParam())));
  const Neighbour neighbour(server, GetParam());
  const int before = neighbour.steps();

  const EntityId ball = Value(world.Add(hull, {.position = {0, 0, 0.5}, .mass = 1}));

  EXPECT_GT(neighbour.steps() - before, 100);
  const client::StepResult result = Value(world.Step(60));
  // As good as a ball.
  EXPECT_NEAR(PositionIn(result.frame, ball).z(), 0.5, 2e-3);
}

}  // namespace
}  // namespace genphys::testing

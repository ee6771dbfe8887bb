// What stands on round ends stands as what has corners does.
#include <cmath>
#include <numbers>
#include <vector>

#include "engine_test.h"
#include "genphys/convex_hull.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(DrumStacks, Claim::kStaticFriction);

constexpr int kBodies = 12;
constexpr double kRadius = 0.5, kHalfHeight = 0.2;  // m
constexpr int kSteps = 600;                         // 10 s
// m. Fifteen boxes of that height sway by 4e-3 until they stand; what comes to as much as this goes on until it falls.
constexpr double kMayMove = 0.02;

ConvexHull Prism(int corners) {
  std::vector<Vector3> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    for (const double z : {-kHalfHeight, kHalfHeight}) {
      points.push_back({kRadius * std::cos(angle), kRadius * std::sin(angle), z});
    }
  }
  return MakeConvexHull(points).value();
}

// m, by how much the one that moved most is off. They are taken in turns, each turned by `turn` (rad) against the last.
double Moved(const std::string& engine, const std::vector<Shape>& shapes, double turn) {
  const auto world = MakeWorld(WorldDesc{.engine = engine, .default_auto_disable = {.enabled = false}});
  std::vector<EntityId> ids;
  const auto place_of = [](int i) { return Vector3(0, 0, kHalfHeight * (2 * i + 1)); };
  for (int i = 0; i < kBodies; ++i) {
    EntityDesc body = Body(shapes[static_cast<size_t>(i) % shapes.size()], place_of(i), 1);
    body.pose.orientation = Eigen::AngleAxisd(turn * i, Vector3::UnitZ());
    ids.push_back(Add(*world, body));
  }
  Steps(*world, kSteps);
  double most = 0;
  for (int i = 0; i < kBodies; ++i) {
    most = std::max(most, (PositionOf(*world, ids[static_cast<size_t>(i)]) - place_of(i)).norm());
  }
  return most;
}

TEST_P(DrumStacks, Stand) {
  for (const double turn : {0.0, 0.7}) {
    EXPECT_LE(Moved(GetParam(), {Cylinder{kRadius, kHalfHeight}}, turn), kMayMove) << turn;
  }
}

TEST_P(DrumStacks, StandWithBoxesAmongThem) {
  EXPECT_LE(Moved(GetParam(), {Cylinder{kRadius, kHalfHeight}, Box{{0.4, 0.4, kHalfHeight}}}, 0), kMayMove);
}

TEST_P(DrumStacks, OfPrismsOfManyCornersStandToo) { EXPECT_LE(Moved(GetParam(), {Prism(16)}, 0), kMayMove); }

}  // namespace
}  // namespace genphys::testing

// What is light carries what is heavy, whatever the shapes, and nobody has to ask for a solver.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine_test.h"
#include "genphys/convex_hull.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(UnevenStacks, Claim::kSolverDirect);

constexpr double kTime = 5;                               // s
constexpr std::array<double, 2> kHalfHeights{0.2, 0.25};  // m, of every other body
// m: what slips or rolls more than this part of its height no longer stands.
constexpr double kMayMove = 0.05 * 2 * kHalfHeights[0];

// Of an odd number of corners, so that it does not give way alike on both sides.
ConvexHull Prism(double radius, double half_height) {
  constexpr int kCorners = 5;
  std::vector<Vector3> points;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    for (const double z : {-half_height, half_height}) {
      points.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  }
  return MakeConvexHull(points).value();
}

Shape ShapeOf(char kind, double half_width, double half_height) {
  switch (kind) {
    case 'b':
      return Box{{half_width, 0.9 * half_width, half_height}};
    case 'd':
      return Cylinder{half_width, half_height};
    case 'p':
      return Prism(half_width, half_height);
    case 'c':
      return Capsule{half_height, half_width};
    default:
      return Sphere{half_height};
  }
}

// From the ground up: boxes, drums, prisms and, on top, a capsule that lies or a sphere. All of about 1 kg but the
// uppermost, which has `ratio` kg.
std::vector<EntityDesc> Stack(const std::string& kinds, double ratio) {
  std::vector<EntityDesc> stack;
  double height = 0;
  for (size_t i = 0; i < kinds.size(); ++i) {
    const double half = kHalfHeights[i % 2], width = 0.3 + 0.02 * static_cast<double>(i * 2 % 5);
    const double aside = i % 2 == 0 ? 1e-5 : -7e-6;
    const double mass = i + 1 < kinds.size() ? 1 + 0.1 * static_cast<double>(i) : ratio;
    EntityDesc body = Body(ShapeOf(kinds[i], width, half), {aside, -aside / 3, height + half}, mass);
    body.pose.orientation = Eigen::AngleAxisd(0.2 * static_cast<double>(i % 3), Vector3::UnitZ());
    if (kinds[i] == 'c') {
      body.pose.orientation = body.pose.orientation * Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY());
    }
    stack.push_back(body);
    height += 2 * half;
  }
  return stack;
}

// m, by how much the one that moved most is off.
double Moved(const std::string& engine, const std::vector<EntityDesc>& stack) {
  const auto world = MakeWorld(WorldDesc{.engine = engine, .default_auto_disable = {.enabled = false}});
  std::vector<EntityId> ids;
  for (const EntityDesc& body : stack) ids.push_back(Add(*world, body));
  Steps(*world, static_cast<int>(kTime * 60));
  double most = 0;
  for (size_t i = 0; i < stack.size(); ++i) {
    most = std::max(most, (PositionOf(*world, ids[i]) - stack[i].pose.position).norm());
  }
  return most;
}

TEST_P(UnevenStacks, StandWhateverTheirShapes) {
  for (const double ratio : {1e2, 1e3}) {
    for (const std::string kinds : {"bbdpdb", "pppbbs", "dpppbb", "dbpppc", "dpdbdc", "ddddbp", "pbpbdd", "dbdbbb"}) {
      EXPECT_LE(Moved(GetParam(), Stack(kinds, ratio)), kMayMove) << kinds << " to " << ratio;
    }
  }
}

// So even a ring of points leaves an exact solver in doubt which of them to let go first.
TEST_P(UnevenStacks, StandAsEvenAsDrumsAre) {
  for (const std::string kinds : {"dd", "db"}) {
    EXPECT_LE(Moved(GetParam(), Stack(kinds, 1e4)), kMayMove) << kinds;
  }
}

// What bears it gives way where it bears most, and it rolls there.
TEST_P(UnevenStacks, StandStraightEnoughForASphere) {
  for (const std::string kinds : {"ps", "pps", "pppbbs"}) {
    EXPECT_LE(Moved(GetParam(), Stack(kinds, 1e4)), kMayMove) << kinds;
  }
}

// Many points of theirs come to their bounds one after the other, in a solve that starts from nothing.
TEST_P(UnevenStacks, StandWithManyPointsUnderTenThousandTimesTheirWeight) {
  for (const std::string kinds : {"ppppb", "pbpbdd", "dpdbdc"}) {
    EXPECT_LE(Moved(GetParam(), Stack(kinds, 1e4)), kMayMove) << kinds;
  }
}

}  // namespace
}  // namespace genphys::testing

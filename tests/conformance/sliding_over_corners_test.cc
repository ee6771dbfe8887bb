// What slides over the corner of level tiles goes on as over one floor.
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "conformance/engine_test.h"
#include "genphys/convex_hull.h"
#include "genphys/surface.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(SlidingOverCorners, Claim::kContacts, Claim::kBox, Claim::kKineticFriction);

constexpr double kGravity = 9.8, kFriction = 0.6, kSpeed = 6;
constexpr double kRadius = 0.1, kHalfHeight = 0.025;
constexpr double kTile = 4;  // m, half of its width

enum class Floor { kWhole, kBoxes, kHulls, kMeshes, kOneBody };

std::vector<Vector3> CornersOf(const Vector3& half) {
  std::vector<Vector3> corners;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) corners.push_back(half.cwiseProduct(Vector3(x, y, z)));
    }
  }
  return corners;
}

Shape TileOf(Floor floor, const Vector3& half) {
  if (floor == Floor::kHulls) return *MakeConvexHull(CornersOf(half));
  if (floor != Floor::kMeshes) return Box{half};
  const double x = half.x(), y = half.y(), z = half.z();
  return *MakeTriangleMesh({{-x, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}}, {0, 1, 2, 0, 2, 3});
}

// Four tiles, or what they are as one, that meet at the origin and are level at zero, turned by `turn` with all the
// world.
std::unique_ptr<World> On(const std::string& engine, Floor floor, int rate, const Quaternion& turn) {
  WorldDesc desc{.engine = engine,
                 .gravity = turn * Vector3(0, 0, -kGravity),
                 .stepper = {.step_size = 1.0 / rate},
                 .ground_plane = false};
  desc.default_material.friction = kFriction;
  desc.default_auto_disable.enabled = false;
  auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  EntityDesc all = Block({0, 0, 0}, {kTile, kTile, 0.5});
  all.pose.orientation = turn;
  if (floor == Floor::kWhole) {
    all.rigid_body->geometries.front().shape = Box{{2 * kTile, 2 * kTile, 0.5}};
    all.pose.position = turn * Vector3(0, 0, -0.5);
    Add(*world, all);
    return world;
  }
  std::vector<Geometry> tiles;
  for (const double x : {-kTile, kTile}) {
    for (const double y : {-kTile, kTile}) {
      tiles.push_back({.shape = TileOf(floor, {kTile, kTile, 0.5}), .pose_in_entity = {{x, y, -0.5}}});
    }
  }
  all.rigid_body->geometries = tiles;
  if (floor == Floor::kOneBody) {
    Add(*world, all);
    return world;
  }
  for (const Geometry& tile : tiles) {
    all.rigid_body->geometries = {Geometry{.shape = tile.shape}};
    all.pose.position = turn * tile.pose_in_entity.position;
    Add(*world, all);
  }
  return world;
}

struct Slider {
  const char* name;
  Shape shape;
};

std::vector<Slider> Sliders() {
  std::vector<Vector3> corners;
  for (int i = 0; i < 6; ++i) {
    const double angle = i * std::acos(0.5);
    for (const double z : {-kHalfHeight, kHalfHeight}) {
      corners.push_back({kRadius * std::cos(angle), kRadius * std::sin(angle), z});
    }
  }
  return {{"cylinder", Cylinder{kRadius, kHalfHeight}},
          {"cone", Cone{kRadius, kHalfHeight}},
          {"hull", *MakeConvexHull(corners)}};
}

// How it comes past the corner: at what time (s), how far from it (m), and to where (rad).
struct Course {
  double time, miss, heading;
};

Course CourseOf(int i) {
  const auto part = [&](double step) { return std::fmod(i * step, 1.0); };
  return {0.05 + 0.0025 * i, 0.2 * part(0.414) - 0.1, 0.2 + 1.2 * part(0.618)};
}

Vector3 AlongOf(const Course& course) { return {std::cos(course.heading), std::sin(course.heading), 0}; }

// Along the floor, from so high (m) above it.
EntityId Throw(World& world, const Shape& shape, const Course& course, const Quaternion& turn, double height = 0) {
  const Vector3 along = AlongOf(course), across = Vector3::UnitZ().cross(along);
  EntityDesc desc = Body(shape, turn * Vector3(course.miss * across - kSpeed * course.time * along +
                                               (kHalfHeight + height) * Vector3::UnitZ()));
  desc.pose.orientation = turn;
  desc.rigid_body->linear_velocity = turn * (kSpeed * along);
  return Add(world, desc);
}

TEST_P(SlidingOverCorners, StopsWhereItWouldOnOneFloor) {
  Proves({Claim::kCylinder, Claim::kCone, Claim::kConvexHull, Claim::kTriangleMesh});
  constexpr double kTime = kSpeed / kFriction / kGravity, kWay = kSpeed * kTime / 2;
  const Quaternion leaning(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()));
  for (const Floor floor : {Floor::kBoxes, Floor::kHulls, Floor::kMeshes, Floor::kOneBody}) {
    for (const auto& [name, shape] : Sliders()) {
      for (int i = 0; i < 40; ++i) {
        const int rate = 30 << i % 3;
        const Quaternion turn = i % 5 == 0 ? leaning : Quaternion::Identity();
        const Course course = CourseOf(i);
        const auto world = On(GetParam(), floor, rate, turn);
        const EntityId id = Throw(*world, shape, course, turn);
        const Vector3 start = PositionOf(*world, id);
        Steps(*world, static_cast<int>(std::ceil(kTime * rate)) + 1);
        const Pose end = world->state().pose(EntityRow{id.index()});
        EXPECT_LT((end.position - start - kWay * (turn * AlongOf(course))).norm(), 1e-5 * kWay)
            << name << " over floor " << static_cast<int>(floor) << ", course " << i;
        EXPECT_LT(end.orientation.angularDistance(turn), 1e-5);
      }
    }
  }
}

// That what comes down from `height` (m) on a corner goes on as on one floor, on each of the courses.
void ExpectLandsAsOnOneFloor(const std::string& engine, const Slider& slider, double height) {
  for (int i = 0; i < 80; ++i) {
    const int rate = 30 << i % 3;
    Course course = CourseOf(i);
    course.time = std::sqrt(2 * height / kGravity) + 4e-4 * (i % 40);
    const auto land = [&](Floor floor) {
      const auto world = On(engine, floor, rate, Quaternion::Identity());
      const EntityId id = Throw(*world, slider.shape, course, Quaternion::Identity(), height);
      Steps(*world, static_cast<int>(0.2 * rate));
      return std::pair(PositionOf(*world, id), VelocityOf(*world, id));
    };
    const auto [place, velocity] = land(Floor::kBoxes);
    const auto [true_place, true_velocity] = land(Floor::kWhole);
    EXPECT_LT((place - true_place).norm(), 1e-5) << slider.name << " from " << height << " m, course " << i;
    EXPECT_LT((velocity - true_velocity).norm(), 1e-4) << slider.name << " from " << height << " m, course " << i;
  }
}

// Where it lands it is borne from then on, and comes to the next tiles before the substep ends.
TEST_P(SlidingOverCorners, LandsThereAsOnOneFloor) {
  Proves({Claim::kCylinder, Claim::kCone, Claim::kConvexHull});
  for (const double height : {0.001, 0.002, 0.02}) {
    for (const Slider& slider : Sliders()) ExpectLandsAsOnOneFloor(GetParam(), slider, height);
  }
}

// What sinks so slowly is no impact, but for whoever solves contacts.
TEST_P(SlidingOverCorners, SinksThereAsOnOneFloor) {
  Proves({Claim::kCylinder});
  for (const double height : {0.0007, 0.0009}) {
    ExpectLandsAsOnOneFloor(GetParam(), Sliders().front(), height);
  }
}

// A box on balls, which are near to the tile ahead long before they come to it.
TEST_P(SlidingOverCorners, StopsOnFeetWhereItWouldOnOneFloor) {
  Proves({Claim::kSphere});
  constexpr double kSize = 0.18, kFoot = 0.018;
  for (int i = 0; i < 80; ++i) {
    const int rate = 30 << i % 2;
    const double speed = 0.8 + 0.02 * i;
    const Course course = CourseOf(i);
    const Vector3 along = AlongOf(course), across = Vector3::UnitZ().cross(along);
    EntityDesc desc = Body(Box{{kSize / 2, kSize / 2, 2 * kFoot}},
                           course.miss * across - speed / 2 * course.time * along + 3 * kFoot * Vector3::UnitZ());
    for (const double x : {-0.8, 0.8}) {
      for (const double y : {-0.8, 0.8}) {
        desc.rigid_body->geometries.push_back(
            {.shape = Sphere{kFoot}, .pose_in_entity = {{x * kSize, y * kSize, -2 * kFoot}}});
      }
    }
    desc.rigid_body->inertia.center_of_mass = Vector3(0, 0, 0);
    desc.rigid_body->linear_velocity = speed * along;
    const auto stop = [&](Floor floor) -> Vector3 {
      const auto world = On(GetParam(), floor, rate, Quaternion::Identity());
      const EntityId id = Add(*world, desc);
      Steps(*world, static_cast<int>(0.5 * rate));
      return PositionOf(*world, id);
    };
    EXPECT_LT((stop(Floor::kBoxes) - stop(Floor::kWhole)).norm(), 5e-5) << speed << " m/s, course " << i;
  }
}

// A step is no seam, be it a 50th as high as what slides against it.
TEST_P(SlidingOverCorners, StopsAtAStep) {
  Proves({Claim::kCylinder, Claim::kCone, Claim::kConvexHull});
  for (const double height : {1e-3, 5e-3}) {
    for (const auto& [name, shape] : Sliders()) {
      for (int i = 0; i < 40; ++i) {
        const Course course = CourseOf(i);
        const int rate = i % 2 == 0 ? 30 : 60;
        const auto world = On(GetParam(), Floor::kBoxes, rate, Quaternion::Identity());
        Add(*world, Block({kTile, 0, height - 0.5}, {kTile - kRadius, 2 * kTile, 0.5}));
        const EntityId id = Throw(*world, shape, course, Quaternion::Identity());
        const double time = course.time + 2 * kRadius / kSpeed / AlongOf(course).x();
        Steps(*world, static_cast<int>(std::ceil(time * rate)));
        EXPECT_LT(VelocityOf(*world, id).x(), 0.3 * kSpeed * AlongOf(course).x())
            << name << ", " << height << " m, course " << i;
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

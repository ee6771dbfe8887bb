// Rough ground, where edges rise and fall from every corner, holds whatever falls on it.
#include <cmath>
#include <vector>

#include "engine_test.h"
#include "genphys/proximity.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(RoughGround, Claim::kContacts, Claim::kTriangleMesh, Claim::kHeightfield, Claim::kSphere);

constexpr double kCell = 0.5;

std::unique_ptr<World> WorldOn(const std::string& engine, const Shape& ground, double friction) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -9.81}, .ground_plane = false};
  desc.default_material.friction = friction;
  auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  EntityDesc floor = Body(ground, Vector3::Zero());
  floor.rigid_body->motion_type = MotionType::kStatic;
  Add(*world, floor);
  return world;
}

TEST_P(RoughGround, HoldsABallOnAnyCorner) {
  // Of a saddle along the axes or the diagonals, a peak, a pit, and of one with three ways up.
  const std::vector<double (*)(double, double)> corners{
      [](double x, double y) { return 0.2 * x * y; },
      [](double x, double y) { return -0.2 * x * y; },
      [](double x, double y) { return 0.2 * (x * x - y * y); },
      [](double x, double y) { return -0.2 * (std::abs(x) + std::abs(y)); },
      [](double x, double y) { return 0.2 * (std::abs(x) + std::abs(y)); },
      [](double x, double y) { return 0.2 * x * (x * x - 3 * y * y); }};
  for (const auto& height : corners) {
    for (const Shape& ground : {Shape{GroundMesh(kCell, 2, height)}, Shape{Ground(3, kCell, height)}}) {
      for (const double aside : {0.0, 1e-9, 1e-3}) {
        for (const double drop : {5e-4, 1.0}) {
          constexpr double kRadius = 0.3;
          const auto world = WorldOn(GetParam(), ground, 0.5);
          const EntityId ball = Add(*world, Ball({aside, aside, kRadius + 0.02 + drop}, kRadius));
          // It is still over the ground then, from where it may roll down later.
          double lowest = 1;
          for (int step = 0; step < 60; ++step) {
            Steps(*world, 1);
            const Vector3 place = PositionOf(*world, ball);
            if (place.head<2>().cwiseAbs().maxCoeff() > kCell) break;
            lowest = std::min(lowest, place.z() - height(place.x(), place.y()));
          }
          EXPECT_GT(lowest, 0.95 * kRadius) << &height - corners.data() << " on " << ground.index() << ", " << aside
                                            << " m beside, from " << drop << " m";
        }
      }
    }
  }
}

TEST_P(RoughGround, LosesNothingThatFallsAndRollsOnIt) {
  Proves({Claim::kBox, Claim::kCapsule, Claim::kCylinder, Claim::kCone, Claim::kEllipsoid, Claim::kConvexHull});
  constexpr int kSide = 5;  // of the square of bodies of one shape
  constexpr double kRoughness = 0.1, kApart = 1.9, kSize = 0.2;
  const std::vector<Shape> shapes{
      Sphere{0.3},    Box{{0.3, 0.2, 0.25}},       Capsule{0.2, 0.2},        Cylinder{0.25, 0.2},
      Cone{0.3, 0.3}, Ellipsoid{{0.35, 0.2, 0.3}}, HullBox({0.2, 0.3, 0.25})};
  for (const Shape& shape : shapes) {
    for (const bool is_field : {false, true}) {
      Random random(5);
      const auto bumps = [&](double, double) { return random.Uniform(-kRoughness, kRoughness); };
      const Shape ground = is_field ? Shape{Ground(33, kCell, bumps)} : Shape{GroundMesh(16 * kCell, 32, bumps)};
      const auto world = WorldOn(GetParam(), ground, 0.5);
      std::vector<EntityId> bodies;
      for (int i = 0; i < kSide * kSide; ++i) {
        EntityDesc body = Body(shape, {kApart * (i % kSide - kSide / 2) + random.Uniform(-0.3, 0.3),
                                       kApart * (i / kSide - kSide / 2) + random.Uniform(-0.3, 0.3), 1.2});
        body.pose.orientation = random.Turn();
        body.rigid_body->linear_velocity = {random.Uniform(-1, 1), random.Uniform(-1, 1), 0};
        bodies.push_back(Add(*world, body));
      }
      Steps(*world, 150);
      for (const EntityId id : bodies) {
        const Placement place{PositionOf(*world, id),
                              FromColumn(world->state().orientations.col(id.index())).toRotationMatrix()};
        EXPECT_GT(place.position.z(), -kRoughness) << shape.index() << " on " << ground.index();
        const auto found = FindProximity(ground, {}, shape, place, 1);
        EXPECT_TRUE(found && found->distance > -0.02 * kSize) << shape.index() << " on " << ground.index();
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

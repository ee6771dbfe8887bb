#include "core/src/shapes/reach.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/src/shapes/solid.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using testing::Random;

// To the farthest point from `center`: from any point on, the one that lies farthest along the way there is no nearer.
double FarthestFrom(const Vector3& center, const Geometry& geometry, Random& random) {
  const Solid solid(geometry.shape, ToPlacement(geometry.pose_in_entity));
  double farthest = 0;
  for (int start = 0; start < 60; ++start) {
    Vector3 direction = random.Direction();
    for (int i = 0; i < 100; ++i) {
      const Vector3 point = solid.Support(direction) + solid.radius() * direction;
      farthest = std::max(farthest, (point - center).norm());
      direction = (point - center).normalized();
    }
  }
  return farthest;
}

TEST(Reach, IsThatToTheFarthestPoint) {
  constexpr double kRounding = 1e-6;
  const std::vector<Shape> shapes{Sphere{0.3}, Box{{0.5, 0.2, 0.1}}, Capsule{0.1, 0.6}, Cylinder{0.4, 0.2},
                                  Cone{0.3, 0.5}};
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Vector3 turn = random.Vector(3);
    const Quaternion orientation(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    const Geometry geometry{.shape = shapes[seed % shapes.size()], .pose_in_entity = {random.Vector(1), orientation}};
    const Vector3 center = random.Vector(1);

    EXPECT_NEAR(ReachFrom(center, geometry), FarthestFrom(center, geometry, random), kRounding);
  }
}

TEST(Reach, OfAnEllipsoidIsNoLessAndNoMoreThanThatOfItsBox) {
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Vector3 semi_axes(0.5, 0.3, 0.1);
    Geometry geometry{.shape = Ellipsoid{semi_axes}, .pose_in_entity = {random.Vector(1), Quaternion::Identity()}};
    const Vector3 center = random.Vector(1);

    const double reach = ReachFrom(center, geometry);

    EXPECT_GE(reach, FarthestFrom(center, geometry, random) - 1e-9);
    geometry.shape = Box{semi_axes};
    EXPECT_LE(reach, ReachFrom(center, geometry));
  }
}

TEST(Reach, OfABodyIsThatOfItsFarthestGeometry) {
  const Geometry low{.shape = Box{{0.3, 0.3, 0.15}}, .pose_in_entity = {{0, 0, -0.15}, Quaternion::Identity()}};
  const Geometry high{.shape = Box{{0.3, 0.3, 0.15}}, .pose_in_entity = {{0, 0, 0.15}, Quaternion::Identity()}};

  EXPECT_DOUBLE_EQ(ReachFrom(Vector3::Zero(), RigidBody{.geometries = {low, high}}), Vector3(0.3, 0.3, 0.3).norm());
  EXPECT_EQ(ReachFrom(Vector3::Zero(), RigidBody{}), 0);
}

}  // namespace
}  // namespace genphys

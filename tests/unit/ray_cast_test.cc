#include "genphys/ray_cast.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/shapes.h"

namespace genphys {
namespace {

using namespace testing;

// Some dozen operations on numbers of about ten.
constexpr double kRounding = 1e-12;

std::optional<SurfaceHit> Cast(const Shape& shape, const Vector3& origin, const Vector3& translation) {
  return EnterShape(shape, {origin, translation});
}

void ExpectHit(const std::optional<SurfaceHit>& hit, double fraction, const Vector3& normal) {
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->fraction, fraction, kRounding);
  EXPECT_LT((hit->normal - normal.normalized()).norm(), kRounding);
}

TEST(RayCast, HitsAConeOnItsSideAndUnderItsBase) {
  const Cone cone{0.5, 1};
  // Half-way up the cone is half as wide; its side leans by radius / height.
  ExpectHit(Cast(cone, {3, 0, 0}, {-5, 0, 0}), 2.75 / 5, {2, 0, 0.5});
  ExpectHit(Cast(cone, {0.1, 0.2, -3}, {0, 0, 4}), 0.5, -Vector3::UnitZ());
  ExpectHit(Cast(cone, {0, 0, 5}, {0, 0, -10}), 0.4, Vector3::UnitZ());
  ExpectHit(Cast(cone, {0.2, 0, 5}, {0, 0, -10}), (4 + 2 * 0.2 / 0.5) / 10, {2, 0, 0.5});
  EXPECT_FALSE(Cast(cone, {0, 0, -0.5}, {5, 0, 0})) << "from inside";
  EXPECT_FALSE(Cast(cone, {0.3, 0, 5}, {0, 0, -4})) << "too short";
  EXPECT_FALSE(Cast(cone, {0.3, 0, 1.5}, {-1, 0, 0})) << "over the apex, where the other half of the double cone is";
  EXPECT_FALSE(Cast(cone, {0.6, 0, -3}, {0, 0, 9})) << "beside it";
}

TEST(RayCast, HitsAnEllipsoidAtTheEndsOfItsAxes) {
  const Ellipsoid ellipsoid{{1, 2, 3}};
  for (int axis = 0; axis < 3; ++axis) {
    const double semi = ellipsoid.semi_axes[axis];
    ExpectHit(Cast(ellipsoid, 5 * Vector3::Unit(axis), -5 * Vector3::Unit(axis)), 1 - semi / 5, Vector3::Unit(axis));
  }
  EXPECT_FALSE(Cast(ellipsoid, {0.5, 0, 0}, {5, 0, 0})) << "from inside";
}

TEST(RayCast, HitsAHullWhereItHitsTheBox) {
  const Vector3 half(0.5, 0.7, 0.9);
  const ConvexHull hull = HullBox(half);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-2, 2);
  int hits = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vector3 from(place(random), place(random), place(random)), to(place(random), place(random), place(random));
    const auto expected = Cast(Box{half}, from, to - from), found = Cast(hull, from, to - from);
    ASSERT_EQ(expected.has_value(), found.has_value()) << i;
    if (!found) continue;
    ++hits;
    ExpectHit(found, expected->fraction, expected->normal);
  }
  EXPECT_GT(hits, 100);
}

TEST(RayCast, HitsAMeshFromItsFrontAlone) {
  const TriangleMesh ground = GroundMesh(3, 6);
  ExpectHit(Cast(ground, {0.3, 0.4, 2}, {0, 0, -4}), 0.5, Vector3::UnitZ());
  EXPECT_FALSE(Cast(ground, {0.3, 0.4, -2}, {0, 0, 4}));
  EXPECT_FALSE(Cast(ground, {3.1, 0.4, 2}, {0, 0, -4})) << "beside it";
  const TriangleMesh box = BoxMesh({1, 1, 1});
  ExpectHit(Cast(box, {3, 0.2, 0.3}, {-4, 0, 0}), 0.5, Vector3::UnitX());
}

TEST(RayCast, SlipsThroughNoSeam) {
  const TriangleMesh ground = GroundMesh(3, 6, [](double x, double y) { return 0.1 * std::sin(x) + 0.05 * y * y; });
  const Heightfield field = Ground(7, 1, [](double x, double y) { return 0.1 * std::sin(x) + 0.05 * y * y; });
  for (const Shape& shape : {Shape{ground}, Shape{field}}) {
    for (int i = 0; i <= 50; ++i) {
      // Along the seams, and through the grid points.
      const double along = -2.5 + 0.1 * i;
      for (const Vector3& from : {Vector3(along, 1, 5), Vector3(-1, along, 5), Vector3(along, along, 5)}) {
        EXPECT_TRUE(Cast(shape, from, {0, 0, -9})) << from.transpose();
        EXPECT_TRUE(Cast(shape, from + Vector3(0.7, 0.3, 0), {-0.7, -0.3, -9})) << from.transpose();
      }
    }
  }
}

TEST(RayCast, MeetsHeightfieldAndMeshOfTheSameHeightsAlike) {
  const auto height = [](double x, double y) { return 0.3 * std::sin(2 * x) * std::cos(y); };
  const TriangleMesh mesh = GroundMesh(5, 10, height);
  const Heightfield field = Ground(11, 1, height);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-4.9, 4.9);
  for (int i = 0; i < 500; ++i) {
    const Vector3 from(place(random), place(random), 2), to(place(random), place(random), -2);
    const auto on_mesh = Cast(mesh, from, to - from), on_field = Cast(field, from, to - from);
    ASSERT_TRUE(on_mesh && on_field) << i;
    ExpectHit(on_field, on_mesh->fraction, on_mesh->normal);
  }
}

}  // namespace
}  // namespace genphys

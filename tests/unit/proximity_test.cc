#include "genphys/proximity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "genphys/surface.h"
#include "genphys/work_watch.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using namespace testing;

// m, of solids about a metre large: what is promised of distances and of where a sweep ends.
constexpr double kExact = 1e-9;
constexpr double kFar = 1e9;

Placement At(double x, double y, double z, const Quaternion& turn = Quaternion::Identity()) {
  return {{x, y, z}, turn.toRotationMatrix()};
}

void ExpectApart(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb, double distance) {
  const auto one = FindProximity(a, pa, b, pb), other = FindProximity(b, pb, a, pa);
  ASSERT_TRUE(one && other);
  EXPECT_NEAR(one->distance, distance, kExact);
  EXPECT_NEAR(other->distance, distance, kExact);
  EXPECT_NEAR((one->on_b - one->on_a).dot(one->normal), distance, kExact);
  EXPECT_LT((one->on_b - one->on_a - distance * one->normal).norm(), 1e-6);
  EXPECT_LT((other->on_b - other->on_a - distance * other->normal).norm(), 1e-6);
  EXPECT_LT((one->normal + other->normal).norm(), 1e-6);
  EXPECT_FALSE(FindProximity(a, pa, b, pb, distance - 1e-6));
  EXPECT_TRUE(FindProximity(a, pa, b, pb, distance + 1e-6));
}

TEST(Proximity, FollowsClosedForms) {
  ExpectApart(Sphere{0.5}, At(0, 0, 0), Sphere{0.3}, At(3, 4, 0), 4.2);
  ExpectApart(Sphere{0.5}, At(3, 4, 5), Box{{1, 1, 1}}, At(0, 0, 0), Vector3(2, 3, 4).norm() - 0.5);
  ExpectApart(Capsule{0.2, 1}, At(0, 0, 0), Capsule{0.1, 1}, At(1, 0, 0.5), 0.7);
  ExpectApart(HullBox({1, 1, 1}), At(0, 0, 0), Box{{1, 1, 1}}, At(4, 0.3, 0.2), 2);
  ExpectApart(Cone{0.5, 1}, At(0, 0, 0), Box{{1, 1, 1}}, At(0, 0, 4), 2);
  ExpectApart(Ellipsoid{{1, 2, 3}}, At(0, 0, 0), Ellipsoid{{3, 2, 1}}, At(0, 0, 7), 3);
  ExpectApart(Plane{}, At(0, 0, 1), Cylinder{0.5, 1}, At(3, 4, 5), 3);
  ExpectApart(GroundMesh(3, 6), At(0, 0, 1), Sphere{0.5}, At(0.3, 0.1, 3), 1.5);
  ExpectApart(GroundMesh(3, 6), At(0, 0, 0), Sphere{0.5}, At(6, 0.1, 4), 4.5);
  ExpectApart(Ground(5, 1), At(0, 0, 0), Box{{0.5, 0.5, 0.5}}, At(0.3, 0.1, 2), 1.5);
  ExpectApart(BoxMesh({1, 1, 1}), At(0, 0, 0), BoxMesh({1, 1, 1}), At(3.5, 0.3, 0.2), 1.5);
  ExpectApart(BoxMesh({1, 1, 1}), At(0, 0, 4), Plane{}, At(0, 0, 0.5), 2.5);
}

TEST(Proximity, IsNegativeByTheDepthOfAnOverlap) {
  EXPECT_NEAR(FindProximity(Box{{1, 1, 1}}, At(0, 0, 0), HullBox({1, 1, 1}), At(1.7, 0.3, 0.2))->distance, -0.3,
              kExact);
  EXPECT_NEAR(FindProximity(Sphere{0.5}, At(0, 0, 0), Plane{}, At(0, 0, 0.2))->distance, -0.7, kExact);
  EXPECT_NEAR(FindProximity(Ground(5, 1), At(0, 0, 0), Sphere{0.5}, At(0.1, 0.2, -2))->distance, -2.5, kExact);
  EXPECT_NEAR(FindProximity(GroundMesh(3, 6), At(0, 0, 0), Sphere{0.5}, At(0.1, 0.2, 0.3))->distance, -0.2, kExact);
}

std::vector<Shape> Movers() {
  return {Sphere{0.5},    Box{{0.5, 0.4, 0.3}},       Capsule{0.3, 0.4},       Cylinder{0.4, 0.5},
          Cone{0.5, 0.6}, Ellipsoid{{0.6, 0.4, 0.5}}, HullBox({0.4, 0.3, 0.5})};
}

TEST(Proximity, ToASurfaceIsThatToTheNearestOfItsTriangles) {
  const auto bumpy = [](double x, double y) { return 0.3 * std::sin(3 * x) * std::cos(2 * y); };
  const TriangleMesh mesh = GroundMesh(2, 8, bumpy);
  const Heightfield field = Ground(9, 0.5, bumpy);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-3, 3);
  for (const Shape& shape : Movers()) {
    for (int i = 0; i < 20; ++i) {
      const Placement there = At(place(random), place(random), 2.5 + place(random) / 3);
      double least = kFar;
      for (const MeshData::Triangle& t : mesh.data->triangles) {
        const auto& vertices = mesh.data->vertices;
        const Shape one = MakeTriangleMesh({vertices[t[0]], vertices[t[1]], vertices[t[2]]}, {0, 1, 2}).value();
        least = std::min(least, FindProximity(one, At(0, 0, 0), shape, there)->distance);
      }
      for (const Shape& surface : {Shape(mesh), Shape(field)}) {
        EXPECT_NEAR(FindProximity(surface, At(0, 0, 0), shape, there)->distance, least, kExact);
        EXPECT_NEAR(FindProximity(shape, there, surface, At(0, 0, 0))->distance, least, kExact);
        EXPECT_FALSE(FindProximity(surface, At(0, 0, 0), shape, there, least - kExact));
        EXPECT_TRUE(FindProximity(surface, At(0, 0, 0), shape, there, least + kExact));
      }
    }
  }
}

// How often a search of the distance told that it worked.
int LooksOf(const Shape& a, const Shape& b, const Placement& placement_b) {
  int looks = 0;
  const WorkWatch watch([&] { return ++looks, absl::OkStatus(); }, 1);
  FindProximity(a, At(0, 0, 0), b, placement_b);
  return looks;
}

TEST(Proximity, ToALargeSurfaceTakesAFewLooks) {
  for (const bool is_flat : {true, false}) {
    const auto height = [&](double x, double y) { return is_flat ? 0.0 : std::sin(3 * x) * std::cos(2 * y); };
    const Heightfield field = Ground(257, 1, height);
    const TriangleMesh mesh = GroundMesh(128, 256, height);
    for (const Shape& surface : {Shape(field), Shape(mesh)}) {
      EXPECT_LT(LooksOf(surface, Sphere{0.5}, At(3.3, -7.1, 50)), 5000) << "of 131,072 triangles";
      EXPECT_GT(LooksOf(surface, Sphere{0.5}, At(3.3, -7.1, 50)), 8);
    }
    // Above and below each other, and in either order.
    for (const double above : {50.0, -50.0}) {
      EXPECT_LT(LooksOf(field, mesh, At(0, 0, above)), 20 * 131'072) << is_flat << ' ' << above;
    }
  }
}

TEST(Proximity, IsCutShortWhereverItIsBeingLookedFor) {
  const Shape field = Ground(65, 1, [](double x, double y) { return std::sin(3 * x) * std::cos(2 * y); });
  for (const Shape& other : {Shape(Sphere{0.5}), field}) {
    const int most = LooksOf(field, other, At(0, 0, 20));
    for (int last = 1; last < most; last += 1 + most / 50) {
      int asked = 0;
      const WorkWatch watch([&] { return ++asked == last ? absl::CancelledError("") : absl::OkStatus(); }, 1);
      EXPECT_THROW(FindProximity(field, At(0, 0, 0), other, At(0, 0, 20)), CutShort) << last;
    }
  }
}

TEST(Sweep, EndsWhereTheShapesTouchAndNotBefore) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Vector3(normal(random), normal(random), normal(random)).normalized(); };
  const auto turn = [&] {
    return Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
  };
  std::vector<Shape> targets = Movers();
  targets.insert(targets.end(), {Plane{}, BoxMesh({0.5, 0.4, 0.3}), Ground(9, 0.5, [](double x, double y) {
                                   return 0.2 * std::sin(3 * x) * std::cos(2 * y);
                                 })});
  int hits = 0, misses = 0;
  for (const Shape& shape : Movers()) {
    for (const Shape& target : targets) {
      for (int i = 0; i < 10; ++i) {
        Vector3 from = 4 * direction();
        if (!IsConvex(target)) from.z() = std::abs(from.z()) + 1.5;
        const Placement start = {from, turn().toRotationMatrix()};
        const Vector3 translation = 2 * (1.2 * direction() - from);
        const auto hit = SweepShape(shape, start, translation, target, {});
        const auto distance_at = [&](double fraction) {
          return FindProximity(shape, {from + fraction * translation, start.rotation}, target, {})->distance;
        };
        SCOPED_TRACE(::testing::Message() << shape.index() << " to " << target.index() << " " << i);
        if (!hit) {
          ++misses;
          for (int k = 0; k <= 20; ++k) EXPECT_GT(distance_at(k / 20.0), -kExact);
          continue;
        }
        ++hits;
        EXPECT_NEAR(distance_at(hit->fraction), 0, 1e-8);
        for (int k = 0; k < 20; ++k) EXPECT_GT(distance_at(hit->fraction * k / 20.0), -kExact);
        EXPECT_LT(hit->normal.dot(translation), 0);
      }
    }
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(misses, 20);
}

TEST(Sweep, StartsAtOnceFromAnOverlap) {
  for (const Shape& target : {Shape{Box{{1, 1, 1}}}, Shape{Plane{}}, Shape{GroundMesh(3, 4)}, Shape{Ground(4, 1)}}) {
    const double surface = std::holds_alternative<Box>(target) ? 1 : 0;
    const auto hit = SweepShape(Sphere{0.5}, At(0.1, 0.2, surface + 0.4), {1, 0, 0}, target, {});
    ASSERT_TRUE(hit.has_value());
    EXPECT_EQ(hit->fraction, 0);
    EXPECT_LT((hit->normal - Vector3::UnitZ()).norm(), kExact);
  }
}

TEST(Sweep, FollowsClosedForms) {
  const auto hit = SweepShape(Sphere{0.5}, At(0, 0.6, 5), {0, 0, -10}, Sphere{0.5}, {});
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->fraction, (5 - 0.8) / 10, kExact);
  EXPECT_LT((hit->normal - Vector3(0, 0.6, 0.8)).norm(), 1e-6);
  EXPECT_LT((hit->position - Vector3(0, 0.3, 0.4)).norm(), 1e-6);
  EXPECT_FALSE(SweepShape(Sphere{0.5}, At(0, 1.001, 5), {0, 0, -10}, Sphere{0.5}, {}));
  EXPECT_TRUE(SweepShape(Sphere{0.5}, At(0, 0.999, 5), {0, 0, -10}, Sphere{0.5}, {}));
  EXPECT_FALSE(SweepShape(Sphere{0.5}, At(0, 0, 5), {0, 0, -3.999}, Sphere{0.5}, {}));
  EXPECT_TRUE(SweepShape(Sphere{0.5}, At(0, 0, 5), {0, 0, -4.001}, Sphere{0.5}, {}));
  EXPECT_FALSE(SweepShape(Sphere{0.5}, At(0, 0, 5), {0, 0, 10}, Plane{}, {}));
}

}  // namespace
}  // namespace genphys

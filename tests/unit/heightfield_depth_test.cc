// All that lies straight below a heightfield is in it, and what is in the air beside a steep place is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/src/shapes/solid.h"
#include "genphys/narrow_phase.h"
#include "genphys/proximity.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using namespace testing;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr uint32_t kPoints = 7;
constexpr double kCell = 0.4;
// Half the side of such a ground, m.
constexpr double kHalf = (kPoints - 1) * kCell / 2;

// Of about a metre, times `scale`.
std::vector<Shape> Solids(double scale) {
  return {Sphere{0.3 * scale},
          Box{scale * Vector3(0.25, 0.5, 0.12)},
          Capsule{0.2 * scale, 0.4 * scale},
          Cylinder{0.25 * scale, 0.3 * scale},
          Cone{0.3 * scale, 0.4 * scale},
          Ellipsoid{scale * Vector3(0.4, 0.2, 0.3)},
          HullBox(scale * Vector3(0.4, 0.3, 0.5))};
}

int CountOf(const Shape& surface, const Shape& shape, const Placement& place, double gap) {
  Manifold manifold;
  FindContacts(surface, {}, shape, place, gap, manifold);
  return manifold.count;
}

// A square ground and all below it as one convex column for each of its triangles.
struct Terrain {
  Heightfield field;
  TriangleMesh mesh;
  std::vector<ConvexHull> columns;
};

Terrain Steep(uint64_t seed) {
  constexpr double kDown = 4;
  Random random(seed);
  Terrain terrain{.field = Ground(kPoints, kCell, [&](double, double) { return random.Uniform(0, 0.8); })};
  std::vector<Vector3> vertices;
  std::vector<uint32_t> indices;
  for (uint32_t r = 0; r < kPoints; ++r) {
    for (uint32_t c = 0; c < kPoints; ++c) vertices.push_back(terrain.field.data->Point(r, c));
  }
  for (uint32_t r = 0; r + 1 < kPoints; ++r) {
    for (uint32_t c = 0; c + 1 < kPoints; ++c) {
      const uint32_t a = r * kPoints + c, b = a + 1, d = a + kPoints, e = d + 1;
      indices.insert(indices.end(), {a, b, e, a, e, d});
    }
  }
  for (size_t i = 0; i < indices.size(); i += 3) {
    std::vector<Vector3> corners;
    for (size_t k = 0; k < 3; ++k) {
      corners.push_back(vertices[indices[i + k]]);
      corners.push_back(corners.back() - kDown * Vector3::UnitZ());
    }
    terrain.columns.push_back(*MakeConvexHull(corners));
  }
  terrain.mesh = *MakeTriangleMesh(vertices, indices);
  return terrain;
}

// Negative where they overlap.
double GapTo(const Terrain& terrain, const Shape& shape, const Placement& place) {
  double gap = kInfinity;
  for (const ConvexHull& column : terrain.columns) {
    const auto found = FindProximity(column, {}, shape, place, std::max(gap, 0.0));
    if (found) gap = std::min(gap, found->distance);
  }
  return gap;
}

TEST(HeightfieldDepth, WhatHoversBesideARidgeIsAsFarFromItAsFromAMesh) {
  // Along the diagonal of the cells, steeper than it is high: behind one side is the air over the other one.
  constexpr double kClear = 0.04, kRadius = 0.03;
  for (const double height : {0.2, 0.4, 0.6, 1.0}) {
    const auto ridge = [&](double x, double y) { return std::abs(x - y) < 0.1 ? height : 0.0; };
    const double across = kCell / std::sqrt(2);
    const Vector3 up = Vector3(height / std::sqrt(2), -height / std::sqrt(2), across).normalized();
    const Vector3 on_slope(0.2 + 0.6 * kCell / 2, 0.2 - 0.6 * kCell / 2, 0.4 * height);
    const Heightfield field = Ground(kPoints, kCell, ridge);
    for (const Shape& shape : {Shape{Sphere{kRadius}}, Shape{Box{Vector3::Constant(kRadius)}}}) {
      const double reach = Solid(shape, {Vector3::Zero(), Matrix3::Identity()}).Reach(-up);
      const Placement place{on_slope + (reach + kClear) * up, Matrix3::Identity()};
      const auto found = FindProximity(field, {}, shape, place);
      ASSERT_TRUE(found);
      EXPECT_NEAR(found->distance, kClear, 1e-9) << shape.index() << ", " << height;
      EXPECT_EQ(CountOf(field, shape, place, 0.9 * kClear), 0) << shape.index() << ", " << height;
      EXPECT_GT(CountOf(field, shape, place, 1.1 * kClear), 0) << shape.index() << ", " << height;
      EXPECT_TRUE(SweepShape(shape, place, -2 * kClear * up, field, {})->fraction > 0) << shape.index();
    }
  }
}

TEST(HeightfieldDepth, WhatIsClearOfASteepGroundIsToldItsDistanceAndWhatIsBelowAnOverlap) {
  int clear = 0, below = 0;
  for (const double scale : {0.1, 0.4, 1.0}) {
    for (uint64_t seed = 1; seed <= 4; ++seed) {
      const Terrain terrain = Steep(seed);
      Random random(seed);
      for (const Shape& shape : Solids(scale)) {
        for (int i = 0; i < 40; ++i) {
          const Placement place{{random.Uniform(-kHalf, kHalf), random.Uniform(-kHalf, kHalf), random.Uniform(-0.4, 1)},
                                random.Turn().toRotationMatrix()};
          const double gap = GapTo(terrain, shape, place);
          const auto found = FindProximity(terrain.field, {}, shape, place);
          ASSERT_TRUE(found);
          if (gap > 1e-4) {
            ++clear;
            // Of two distances between round solids, each exact to 1e-9 of the size.
            EXPECT_NEAR(found->distance, FindProximity(terrain.mesh, {}, shape, place)->distance, 2e-9);
            EXPECT_EQ(CountOf(terrain.field, shape, place, 0.99 * gap), 0) << shape.index() << ", " << gap;
          } else if (gap < -1e-4) {
            ++below;
            EXPECT_LT(found->distance, 0) << shape.index() << ", " << gap;
          }
        }
      }
    }
  }
  EXPECT_GT(clear, 500);
  EXPECT_GT(below, 500);
}

TEST(HeightfieldDepth, IsNoMoreThanTheLiftThatFreesWhatIsSmallerThanACell) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Terrain terrain = Steep(seed);
    Random random(seed);
    for (const Shape& shape : Solids(0.1)) {
      for (int i = 0; i < 100; ++i) {
        Placement place{{random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-0.4, 0.8)},
                        random.Turn().toRotationMatrix()};
        const double depth = -FindProximity(terrain.field, {}, shape, place)->distance;
        if (depth < 1e-3) continue;
        place.position.z() += 0.999 * depth;
        EXPECT_LT(GapTo(terrain, shape, place), 0) << shape.index() << ", " << seed << ", " << i;
      }
    }
  }
}

TEST(HeightfieldDepth, OfASlopeIsThatOfAPlaneHoweverDeep) {
  constexpr double kSlope = 0.7;
  const Heightfield slope = Ground(21, kCell, [](double x, double) { return kSlope * x; });
  const Shape plane = Plane{Vector3(-kSlope, 0, 1).normalized(), 0};
  Random random(9);
  for (const Shape& shape : Solids(1)) {
    for (int i = 0; i < 200; ++i) {
      Placement place{{random.Uniform(-1, 1), random.Uniform(-1, 1), 0}, random.Turn().toRotationMatrix()};
      place.position.z() = kSlope * place.position.x() - random.Uniform(1, 2);
      const double depth = FindProximity(plane, {}, shape, place)->distance;
      EXPECT_NEAR(FindProximity(slope, {}, shape, place)->distance, depth, 1e-9) << shape.index() << ", " << i;
    }
  }
}

}  // namespace
}  // namespace genphys

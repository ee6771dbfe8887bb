// Whatever the edges round it do, rise, fall or lie level, the nearest point of a surface is where a solid meets it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "genphys/narrow_phase.h"
#include "genphys/proximity.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using namespace testing;

constexpr double kGap = 1e-3;
// Of a radius: nearer points are one.
constexpr double kSame = 1e-6;
constexpr double kCell = 0.5;
constexpr uint32_t kPoints = 6;
// Within this of the middle what is nearest is no rim, beside which a solid may be behind the surface.
constexpr double kInside = (kPoints - 1) * kCell / 2 - 1e-6;

// As a mesh and as a heightfield. From level up to rounding to steeper than 70 degrees.
std::vector<Shape> Grounds(double roughness, Random& random) {
  std::vector<double> heights(kPoints * kPoints);
  for (double& height : heights) height = random.Uniform(-roughness, roughness);
  const auto height = [&](double x, double y) {
    const auto at = [](double along) { return std::lround(along / kCell + (kPoints - 1) / 2.0); };
    return heights[static_cast<size_t>(at(y) * kPoints + at(x))];
  };
  return {GroundMesh((kPoints - 1) * kCell / 2, kPoints - 1, height), Ground(kPoints, kCell, height)};
}

// A place over a grid point, a grid line or elsewhere, or hardly beside that.
Vector3 PlaceOver(Random& random) {
  const auto line = [&] { return (static_cast<double>(random.Below(kPoints - 2)) + 1.5 - kPoints / 2.0) * kCell; };
  Vector3 place(random.Uniform(-1, 1), random.Uniform(-1, 1), 3);
  if (random.Chance(0.6)) place.x() = line();
  if (random.Chance(0.6)) place.y() = line();
  if (random.Chance(0.5)) place += random.LogUniform(1e-9, 1e-3) * random.Direction();
  return place;
}

struct Nearest {
  double distance = 0;
  Vector3 normal = Vector3::Zero();  // to the solid
};

// Lowers `place` to where the solid is `distance` over the ground; nothing if that ends over the rim.
std::optional<Nearest> Lower(const Shape& ground, const Shape& solid, double distance, Placement& place) {
  for (int i = 0; i < 400; ++i) {
    const auto found = FindProximity(ground, {}, solid, place);
    if (!found || found->distance <= 0) return std::nullopt;
    if (std::abs(found->distance - distance) < 1e-10) {
      if (found->on_a.head<2>().cwiseAbs().maxCoeff() > kInside) return std::nullopt;
      return Nearest{found->distance, found->normal};
    }
    place.position.z() -= found->distance - distance;
  }
  return std::nullopt;
}

std::vector<MeetingPoint> Meet(const Shape& ground, const Shape& solid, const Placement& place) {
  Manifold manifold;
  FindContacts(ground, {}, solid, place, kGap, manifold);
  return {manifold.points.begin(), manifold.points.begin() + manifold.count};
}

MeetingPoint DeepestOf(std::span<const MeetingPoint> points) {
  return *std::ranges::max_element(points, {}, &MeetingPoint::depth);
}

TEST(RoughSurfaces, MeetABallWhereTheyAreNearestToItsCentre) {
  const Shape point = Sphere{1e-4};
  Random random(1);
  int met = 0;
  for (const double roughness : {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 5e-4, 5e-3, 0.05, 0.3, 1.0}) {
    for (int i = 0; i < 80; ++i) {
      for (const Shape& ground : Grounds(roughness, random)) {
        const double radius = random.LogUniform(0.03, 0.5);
        const double depth = random.Chance(0.2) ? -0.9 * kGap : random.LogUniform(1e-7, 0.5 * radius);
        Placement place{PlaceOver(random), Matrix3::Identity()};
        const auto nearest = Lower(ground, point, radius - depth - 1e-4, place);
        if (!nearest) continue;
        ++met;
        const std::vector<MeetingPoint> points = Meet(ground, Sphere{radius}, place);
        ASSERT_FALSE(points.empty()) << roughness << ", " << i << ", " << ground.index() << ", depth " << depth;
        const MeetingPoint deepest = DeepestOf(points);
        EXPECT_NEAR(deepest.depth, depth, kSame * radius) << roughness << ", " << i << ", " << ground.index();
        const bool has_normal = std::ranges::any_of(points, [&](const MeetingPoint& p) {
          return p.depth > depth - kSame * radius && p.normal.dot(nearest->normal) > 1 - 1e-6;
        });
        EXPECT_TRUE(has_normal) << roughness << ", " << i << ", " << ground.index();
        place.position += (depth + 1.01 * kGap) * nearest->normal;
        if (FindProximity(ground, {}, Sphere{radius}, place)->distance > kGap) {
          EXPECT_TRUE(Meet(ground, Sphere{radius}, place).empty()) << roughness << ", " << i;
        }
      }
    }
  }
  EXPECT_GT(met, 1000);
}

std::vector<Shape> Solids() {
  return {Box{{0.3, 0.2, 0.25}},
          Capsule{0.2, 0.3},
          Cylinder{0.25, 0.3},
          Cone{0.3, 0.4},
          Ellipsoid{{0.4, 0.2, 0.3}},
          HullBox({0.2, 0.3, 0.25}),
          *MakeConvexHull({{0.5, 0, -0.4}, {-0.4, 0.4, -0.3}, {-0.4, -0.5, -0.3}, {0, 0.1, 0.6}})};
}

TEST(RoughSurfaces, MeetWhateverComesNearAsNearAsItIs) {
  Random random(2);
  int met = 0;
  for (const double roughness : {1e-7, 5e-4, 5e-3, 0.05, 0.3, 1.0}) {
    for (int i = 0; i < 12; ++i) {
      for (const Shape& ground : Grounds(roughness, random)) {
        for (const Shape& solid : Solids()) {
          Placement place{PlaceOver(random), random.Turn().toRotationMatrix()};
          const auto nearest = Lower(ground, solid, random.LogUniform(1e-5, 0.9 * kGap), place);
          if (!nearest) continue;
          ++met;
          const std::vector<MeetingPoint> points = Meet(ground, solid, place);
          ASSERT_FALSE(points.empty()) << roughness << ", " << i << ", " << solid.index() << ", " << ground.index();
          // What leans over a seam that is nearly level is taken to meet the triangle beside it, and may be somewhat
          // nearer at the seam.
          EXPECT_GT(DeepestOf(points).depth, -nearest->distance - 0.3 * kGap)
              << roughness << ", " << i << ", " << solid.index();
          EXPECT_LT(DeepestOf(points).depth, -nearest->distance + 1e-9)
              << roughness << ", " << i << ", " << solid.index();
        }
      }
    }
  }
  EXPECT_GT(met, 500);
}

// Sharper than a right angle: what comes to it over one side is behind the other one, and in the air.
TEST(RoughSurfaces, ASharpRidgePushesNobodyThroughItself) {
  Random random(3);
  int met = 0;
  for (int i = 0; i < 150; ++i) {
    for (const Shape& ground : Grounds(1, random)) {
      for (const Shape& solid : Solids()) {
        Placement place{PlaceOver(random), random.Turn().toRotationMatrix()};
        const auto nearest = Lower(ground, solid, 1e-5, place);
        if (!nearest) continue;
        ++met;
        const double depth = random.LogUniform(1e-6, 1e-3);
        place.position -= (1e-5 + depth) * nearest->normal;
        const std::vector<MeetingPoint> points = Meet(ground, solid, place);
        ASSERT_FALSE(points.empty()) << ground.index() << ", " << solid.index() << ", " << i;
        EXPECT_GT(DeepestOf(points).depth, 0.5 * depth) << ground.index() << ", " << solid.index() << ", " << i;
        // Up to half of its least half width is not told from what is pressed into the ground.
        EXPECT_LT(DeepestOf(points).depth, 0.1) << ground.index() << ", " << solid.index() << ", " << i;
      }
    }
  }
  EXPECT_GT(met, 500);
}

}  // namespace
}  // namespace genphys

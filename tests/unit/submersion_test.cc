#include "core/src/shapes/submersion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "genphys/convex_hull.h"
#include "genphys/inertia.h"

namespace genphys {
namespace {

using std::numbers::pi;

// The quadrature of bodies of revolution has about this many digits, relative to size and volume.
constexpr double kQuadrature = 1e-9;
constexpr double kRounding = 1e-12;

RigidBody BodyOf(const Shape& shape) {
  RigidBody body;
  body.geometries.emplace_back();
  body.geometries.back().shape = shape;
  return body;
}

Submersion Below(const Shape& shape, double offset, const Vector3& normal = Vector3::UnitZ(), const Pose& pose = {}) {
  return Submerge(BodyOf(shape), pose, normal, offset);
}

const std::vector<Shape>& Solids() {
  static const std::vector<Shape> solids{
      Sphere{0.5},
      Box{{0.3, 0.5, 0.9}},
      Capsule{0.5, 0.4},
      Cylinder{0.5, 0.7},
      Cone{0.5, 0.6},
      Ellipsoid{{0.3, 0.5, 0.9}},
      *MakeConvexHull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.8, 0.7, 0.6}})};
  return solids;
}

TEST(Submersion, OfABallIsASegment) {
  const double r = 0.7, height = 0.5;
  const Submersion part = Below(Sphere{r}, height - r);

  EXPECT_NEAR(part.volume_below, pi * height * height * (3 * r - height) / 3, kRounding);
  EXPECT_NEAR(part.center.z(), -3 * std::pow(2 * r - height, 2) / (4 * (3 * r - height)), kRounding);
}

TEST(Submersion, OfABoxThatFloatsUprightIsASmallerBox) {
  const Submersion part = Below(Box{{0.5, 1, 1.5}}, -0.3);

  EXPECT_NEAR(part.volume_below, 1 * 2 * 1.2, kRounding);
  EXPECT_TRUE(part.center.isApprox(Vector3(0, 0, -0.9), kRounding));
}

TEST(Submersion, OfACubeOnItsCornerIsATetrahedron) {
  // A plane across the corner at (-1, -1, -1) that cuts a length of 0.6 off each of its three edges.
  const double leg = 0.6;
  const Vector3 normal = Vector3(1, 1, 1).normalized();
  const Submersion part = Below(Box{{1, 1, 1}}, normal.dot(Vector3(-1 + leg, -1, -1)), normal);

  EXPECT_NEAR(part.volume_below, leg * leg * leg / 6, kRounding);
  EXPECT_TRUE(part.center.isApprox(Vector3::Constant(-1 + leg / 4), kRounding));
}

TEST(Submersion, OfALyingCylinderIsTheSegmentOfADisc) {
  const double r = 0.5, half_length = 2, depth = 0.2;
  const Submersion part = Below(Cylinder{r, half_length}, depth, Vector3::UnitX());

  const double segment = r * r * std::acos(-depth / r) + depth * std::sqrt(r * r - depth * depth);
  EXPECT_NEAR(part.volume_below, 2 * half_length * segment, kQuadrature);
  EXPECT_NEAR(part.center.x(), -2 * std::pow(r * r - depth * depth, 1.5) / (3 * segment), kQuadrature);
  EXPECT_NEAR(part.center.z(), 0, kQuadrature);
}

TEST(Submersion, OfACylinderCutThroughBothEndsIsHalfOfItWhenTheCutPassesItsCentre) {
  const Vector3 normal = Vector3(0.9, 0, 0.2).normalized();
  const Submersion part = Below(Cylinder{0.5, 1}, 0, normal);

  EXPECT_NEAR(part.volume_below, part.volume / 2, kQuadrature);
}

TEST(Submersion, OfACapsuleThatStandsIsACapAndACylinder) {
  const double r = 0.4, half_length = 0.6, level = 0.1;
  const Submersion part = Below(Capsule{r, half_length}, level);

  EXPECT_NEAR(part.volume_below, 2 * pi * r * r * r / 3 + pi * r * r * (half_length + level), kQuadrature);
}

TEST(Submersion, IsAllOrNothingFarFromTheSurface) {
  for (const Shape& shape : Solids()) {
    const Pose pose{{3, 4, 5}, Quaternion(0.5, 0.5, 0.5, 0.5)};
    const Submersion all = Below(shape, 1e6, Vector3(0.6, 0, 0.8), pose);
    EXPECT_NEAR(all.volume_below / Volume(shape), 1, kQuadrature);
    EXPECT_TRUE(all.center.isApprox(pose.Transform(CenterOfMass(shape)), kQuadrature));
    EXPECT_EQ(Below(shape, -1e6, Vector3(0.6, 0, 0.8)).volume_below, 0);
  }
}

TEST(Submersion, AndItsComplementAreTheWhole) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const Vector3 normal = Vector3(any(random), any(random), any(random)).normalized();
    const Pose pose{Vector3(any(random), any(random), any(random)),
                    Quaternion(any(random), any(random), any(random), any(random)).normalized()};
    const double offset = any(random);
    for (const Shape& shape : Solids()) {
      const Submersion below = Below(shape, offset, normal, pose), above = Below(shape, -offset, -normal, pose);
      const double volume = Volume(shape);
      EXPECT_NEAR(below.volume_below + above.volume_below, volume, kQuadrature);
      const Vector3 moment = below.volume_below * below.center + above.volume_below * above.center;
      EXPECT_LT((moment - volume * pose.Transform(CenterOfMass(shape))).norm(), kQuadrature);
    }
  }
}

TEST(Submersion, CountsNeitherSensorsNorPlanes) {
  RigidBody body = BodyOf(Sphere{0.5});
  body.geometries[0].is_sensor = true;
  body.geometries.emplace_back();
  body.geometries.back().shape = Plane{};

  EXPECT_EQ(Submerge(body, {}, Vector3::UnitZ(), 10).volume, 0);
}

}  // namespace
}  // namespace genphys

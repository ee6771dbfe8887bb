// Where triangles of a surface lie side by side evenly, nothing meets the seam between them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "core/src/shapes/solid.h"
#include "genphys/narrow_phase.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using namespace testing;

const Vector3 kHalf(0.5, 0.4, 0.3);  // of a box

std::vector<Shape> Solids() {
  return {Sphere{0.5},
          Box{kHalf},
          Capsule{0.3, 0.4},
          Cylinder{0.4, 0.5},
          Cone{0.5, 0.6},
          Ellipsoid{{0.6, 0.4, 0.5}},
          HullBox({0.4, 0.3, 0.5}),
          *MakeConvexHull({{0.5, 0, -0.4}, {-0.4, 0.4, -0.3}, {-0.4, -0.5, -0.3}, {0, 0.1, 0.6}})};
}

std::vector<MeetingPoint> Meet(const Shape& surface, const Shape& shape, const Placement& place, double gap) {
  Manifold manifold;
  FindContacts(surface, {}, shape, place, gap, manifold);
  return {manifold.points.begin(), manifold.points.begin() + manifold.count};
}

bool HasPointAt(std::span<const MeetingPoint> points, const Vector3& position, double depth) {
  return std::ranges::any_of(points, [&](const MeetingPoint& point) {
    return (point.position - position).norm() < 1e-9 && std::abs(point.depth - depth) < 1e-9;
  });
}

// Anyhow, or nearly upright.
Matrix3 RandomTurn(Random& random) {
  const Quaternion turn = random.Turn();
  if (random.Chance(0.5)) return turn.toRotationMatrix();
  return Quaternion::Identity().slerp(random.LogUniform(1e-8, 0.1), turn).toRotationMatrix();
}

TEST(SurfaceSeams, AFlatSurfaceMeetsASolidWhereAPlaneDoes) {
  const std::vector<Shape> grounds{GroundMesh(6, 8), GroundMesh(6, 60), Ground(13, 1), Ground(121, 0.1)};
  Random random(3);
  for (const Shape& shape : Solids()) {
    for (int i = 0; i < 150; ++i) {
      const Matrix3 turn = RandomTurn(random);
      const double reach = Solid(shape, {Vector3::Zero(), turn}).Reach(-Vector3::UnitZ());
      const double gap = random.LogUniform(1e-5, 0.1);
      const Placement place{{random.Uniform(-3, 3), random.Uniform(-3, 3), reach + random.Uniform(-0.03, 0.9 * gap)},
                            turn};
      const std::vector<MeetingPoint> wanted = Meet(Plane{}, shape, place, gap);
      for (const Shape& ground : grounds) {
        const std::vector<MeetingPoint> points = Meet(ground, shape, place, gap);
        ASSERT_EQ(points.size(), wanted.size()) << shape.index() << ", " << i;
        for (const MeetingPoint& point : wanted) {
          EXPECT_TRUE(HasPointAt(points, point.position, point.depth)) << shape.index() << ", " << i;
        }
      }
    }
  }
}

// The least slope at which a box that is turned like this rises from its lowest corner to another one.
double LeastSlope(const Matrix3& turn, const Vector3& lowest) {
  double least = 1;
  for (int k = 0; k < 8; ++k) {
    const Vector3 signs(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    const Vector3 way = turn * signs.cwiseProduct(kHalf) - lowest;
    if (way.norm() > 1e-9) least = std::min(least, way.z() / way.head<2>().norm());
  }
  return least;
}

TEST(SurfaceSeams, OnAnEvenSurfaceABoxOnItsCornerMeetsNothingElse) {
  constexpr double kGap = 3e-3;
  const Shape box = Box{kHalf};
  Random random(5);
  for (const double bend : {-0.08, -0.02, 0.0, 0.02, 0.08}) {
    const auto height = [&](double x, double y) { return bend * (x * x + y * y); };
    const std::vector<Shape> grounds{GroundMesh(3, 8, height), GroundMesh(3, 40, height), Ground(7, 1, height),
                                     Ground(61, 0.1, height)};
    for (int i = 0; i < 400; ++i) {
      const Matrix3 turn = random.Turn().toRotationMatrix();
      const Vector3 lowest = Solid(box, {Vector3::Zero(), turn}).Support(-Vector3::UnitZ());
      const Vector3 at(random.Uniform(-0.6, 0.6), random.Uniform(-0.6, 0.6), 0);
      // Steeper than the ground is within a metre and a half.
      if (LeastSlope(turn, lowest) < 0.5) continue;
      for (const Shape& ground : grounds) {
        Placement place{at + Vector3(0, 0, 0.5) - lowest, turn};
        for (double step = 0.5; step > 1e-4; step /= 2) {
          if (Meet(ground, box, {place.position - step * Vector3::UnitZ(), turn}, 0).empty()) {
            place.position.z() -= step;
          }
        }
        for (const double deeper : {-2e-3, 1e-4, 2e-3}) {
          const Placement there{place.position - deeper * Vector3::UnitZ(), turn};
          const std::vector<MeetingPoint> points = Meet(ground, box, there, kGap);
          EXPECT_FALSE(points.empty()) << bend << ", " << i << ", " << deeper;
          for (const MeetingPoint& point : points) {
            const double aside = (point.position - there.position - lowest).norm();
            EXPECT_LT(aside, std::abs(point.depth) + 1e-9) << bend << ", " << i << ", " << deeper;
          }
        }
      }
    }
  }
}

TEST(SurfaceSeams, WhatLiesFlatOverABendLiesOnTheBend) {
  const Shape box = Box{kHalf};
  for (const double slope : {1e-3, 0.05, 0.5}) {
    const auto ridge = [&](double x, double) { return -slope * std::abs(x); };
    const auto peak = [&](double x, double y) { return -slope * std::max(std::abs(x), std::abs(y)); };
    const Placement place{{0.1, 0.03, kHalf.z() - 1e-5}, Matrix3::Identity()};
    for (const auto& [on_ridge, on_peak] : {std::pair<Shape, Shape>(GroundMesh(3, 6, ridge), GroundMesh(3, 6, peak)),
                                            std::pair<Shape, Shape>(Ground(7, 1, ridge), Ground(7, 1, peak))}) {
      const std::vector<MeetingPoint> along = Meet(on_ridge, box, place, 2e-5);
      EXPECT_TRUE(HasPointAt(along, {0, 0.43, -5e-6}, 1e-5)) << slope;
      EXPECT_TRUE(HasPointAt(along, {0, -0.37, -5e-6}, 1e-5)) << slope;
      EXPECT_TRUE(HasPointAt(Meet(on_peak, box, place, 2e-5), {0, 0, -5e-6}, 1e-5)) << slope;
    }
  }
}

TEST(SurfaceSeams, WhatLiesOverTheRimEndsThere) {
  const Placement place{{1.9, 0.1, kHalf.z() - 1e-5}, Matrix3::Identity()};
  for (const Shape& ground : {Shape{GroundMesh(2, 8)}, Shape{Ground(9, 0.5)}}) {
    const std::vector<MeetingPoint> points = Meet(ground, Box{kHalf}, place, 1e-3);
    ASSERT_EQ(points.size(), 4u);
    for (const double x : {1.4, 2.0}) {
      for (const double y : {-0.3, 0.5}) EXPECT_TRUE(HasPointAt(points, {x, y, -5e-6}, 1e-5)) << x << ", " << y;
    }
  }
}

TEST(SurfaceSeams, ACornerBesideTheRimIsAllThatComesToIt) {
  const Matrix3 turn = Quaternion::FromTwoVectors(Vector3(0.9, 1, 1.1), Vector3::UnitZ()).toRotationMatrix();
  const Vector3 lowest = Solid(Box{kHalf}, {Vector3::Zero(), turn}).Support(-Vector3::UnitZ());
  for (const auto& [ground, level] :
       {std::pair<Shape, double>(GroundMesh(2, 8), 0), std::pair<Shape, double>(Ground(9, 0.5), 0),
        std::pair<Shape, double>(BoxMesh({2, 2, 0.5}), 0.5)}) {
    for (const double inward : {1e-4, 1e-3, 3e-3}) {
      const Vector3 corner(2 - inward, 0.1, level + 1e-5);
      const std::vector<MeetingPoint> points = Meet(ground, Box{kHalf}, {corner - lowest, turn}, 3e-3);
      ASSERT_EQ(points.size(), 1u) << inward;
      EXPECT_LT((points[0].position - corner).norm(), 1e-5) << inward;
    }
  }
}

}  // namespace
}  // namespace genphys

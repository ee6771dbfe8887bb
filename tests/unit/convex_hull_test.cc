#include "genphys/convex_hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <numbers>
#include <random>

#include "genphys/inertia.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using testing::HullBox;

constexpr double kRounding = 1e-12;  // relative: some hundred operations in double precision

const Quaternion kTumble(Eigen::AngleAxisd(37 * M_PI / 180, Vector3(1, 2, 3).normalized()));

std::string WhyNot(const std::vector<Vector3>& points) {
  const Result<ConvexHull> hull = MakeConvexHull(points);
  if (hull.ok()) return "";
  const Refusal refusal = *RefusalOf(hull.status());
  return std::string(NameOf(refusal.reason)) + " " + refusal.field;
}

std::vector<Vector3> PointsOnBall(int count, double radius) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) {
    points.push_back(radius * Vector3(normal(random), normal(random), normal(random)).normalized());
  }
  return points;
}

TEST(ConvexHull, OfACubeHasEightCornersAndSixSquaresWhateverElseLiesInIt) {
  for (const Quaternion& turn : {Quaternion(Quaternion::Identity()), kTumble}) {
    std::vector<Vector3> points;
    for (int x = 0; x <= 2; ++x) {
      for (int y = 0; y <= 2; ++y) {
        // Corners, middles of edges and of faces, and the centre, each of them twice.
        for (int z = 0; z <= 2; ++z) points.insert(points.end(), 2, turn * Vector3(x - 1, y - 1, z - 1));
      }
    }
    const Result<ConvexHull> hull = MakeConvexHull(points);
    ASSERT_TRUE(hull.ok()) << hull.status();
    EXPECT_EQ(hull->data->vertices.size(), 8u);
    ASSERT_EQ(hull->data->faces.size(), 6u);
    for (const HullData::Face& face : hull->data->faces) {
      EXPECT_EQ(face.count, 4u);
      EXPECT_NEAR(face.offset, 1, kRounding);
    }
    EXPECT_NEAR(hull->data->volume, 8, 8 * kRounding);
    EXPECT_NEAR(hull->data->thickness, 2, kRounding);
  }
}

TEST(ConvexHull, OfSinglePrecisionCornersStillHasFlatFaces) {
  std::vector<Vector3> points;
  const ConvexHull box = HullBox({0.3, 0.5, 0.7}, kTumble);
  for (const Vector3& corner : box.data->points) {
    points.push_back(corner.cast<float>().cast<double>());
  }
  const Result<ConvexHull> hull = MakeConvexHull(points);
  ASSERT_TRUE(hull.ok()) << hull.status();
  EXPECT_EQ(hull->data->faces.size(), 6u);
}

TEST(ConvexHull, HoldsAllPointsAndIsClosed) {
  const std::vector<Vector3> points = PointsOnBall(3000, 2.0);
  const Result<ConvexHull> hull = MakeConvexHull(points);
  ASSERT_TRUE(hull.ok()) << hull.status();
  const HullData& data = *hull->data;
  // Coplanar is what lies within 5e-7 of the extent, which is 4 m.
  for (const HullData::Face& face : data.faces) {
    for (const Vector3& point : points) ASSERT_LE(face.normal.dot(point), face.offset + 2e-6);
  }
  const size_t edges = data.neighbors.size() / 2;
  EXPECT_EQ(data.vertices.size() + data.faces.size(), edges + 2) << "Euler";
}

TEST(ConvexHull, WeighsWhatABoxWeighsWhereverItLies) {
  const Vector3 half(0.3, 0.5, 0.7), far(50, -20, 30);
  std::vector<Vector3> points;
  const ConvexHull box = HullBox(half, kTumble);
  for (const Vector3& corner : box.data->points) points.push_back(far + corner);
  const Result<ConvexHull> hull = MakeConvexHull(points);
  ASSERT_TRUE(hull.ok()) << hull.status();
  const Matrix3 turn = kTumble.toRotationMatrix();
  const Matrix3 tensor = turn * UnitDensityTensor(Box{half}) * turn.transpose();
  // The corners were rounded where they lie, 60 m from their origin.
  const double rounding = kRounding * 100;
  EXPECT_NEAR(Volume(*hull), Volume(Box{half}), rounding);
  EXPECT_LT((CenterOfMass(*hull) - far).norm(), rounding);
  EXPECT_LT((UnitDensityTensor(*hull) - tensor).norm(), rounding);
}

TEST(ConvexHull, OfATetrahedronHasItsClosedForm) {
  const Result<ConvexHull> hull = MakeConvexHull({{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}});
  ASSERT_TRUE(hull.ok()) << hull.status();
  EXPECT_NEAR(Volume(*hull), 1, kRounding);
  EXPECT_LT((CenterOfMass(*hull) - Vector3(0.25, 0.5, 0.75)).norm(), kRounding);
  // About the centre: 3 V / 80 (b^2 + c^2) on the diagonal, V / 80 a b off it, for legs a, b and c.
  Matrix3 tensor;
  tensor << 3 * 13, 2, 3, 2, 3 * 10, 6, 3, 6, 3 * 5;
  EXPECT_LT((UnitDensityTensor(*hull) - tensor / 80).norm(), kRounding);
}

TEST(ConvexHull, OfAHundredThousandPointsIsMadeInSecondsAndWeighsRight) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
  std::vector<Vector3> points;
  for (int i = 0; i < 100'000; ++i) {
    const double a = angle(random);
    points.push_back({std::cos(a), std::sin(a), i % 2 == 0 ? 0.0 : 1.0});
  }
  const std::clock_t start = std::clock();
  const Result<ConvexHull> hull = MakeConvexHull(points);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  ASSERT_TRUE(hull.ok()) << hull.status();
  // A polygon of n corners at random misses about 4 pi^3 / n^2 of the circle, 5e-8, and the hull leaves out corners
  // that stand out by less than it can tell, at most 5e-7 of its extent.
  EXPECT_NEAR(Volume(*hull), std::numbers::pi, 1e-6);
  // Of the processor, so that others do not count. It takes one or two; sixty leave room for sanitizers.
  EXPECT_LT(seconds, 60);
}

TEST(ConvexHull, RefusesWhatBoundsNoBody) {
  const std::string flat = "INVALID_VALUE vertices";
  EXPECT_EQ(WhyNot({}), flat);
  EXPECT_EQ(WhyNot({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), flat);
  EXPECT_EQ(WhyNot({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}}), flat) << "on a line";
  EXPECT_EQ(WhyNot({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {0.3, 0.4, 1}}), flat) << "in a plane";
  EXPECT_EQ(WhyNot(std::vector<Vector3>(9, Vector3(1, 2, 3))), flat) << "one point";
  EXPECT_EQ(WhyNot({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, NAN}}), "NOT_FINITE vertices[11]");
  EXPECT_EQ(WhyNot({{0, 0, 0}, {1, 0, 0}, {0, -1.1e5, 0}, {0, 0, 1}}), "OUT_OF_RANGE vertices[7]");
}

TEST(ConvexHull, MayBeThinButNotTooThin) {
  const auto plate = [](double thickness) {
    std::vector<Vector3> points;
    const ConvexHull box = HullBox({0.5, 0.4, 0.3});
    for (const Vector3& corner : box.data->points) {
      points.push_back(corner.cwiseProduct(Vector3(1, 1, thickness / 0.6)));
    }
    return points;
  };
  EXPECT_EQ(WhyNot(plate(1e-4)), "");
  EXPECT_EQ(WhyNot(plate(2.1e-5)), "");
  EXPECT_EQ(WhyNot(plate(1.9e-5)), "INVALID_VALUE vertices");
}

TEST(ConvexHull, WorksFromTheSmallestToTheLargestSize) {
  for (const double half : {1e-5, 1e-3, 1e3, 1e5}) {
    const ConvexHull hull = HullBox(Vector3::Constant(half));
    ASSERT_NE(hull.data, nullptr) << half;
    EXPECT_NEAR(hull.data->volume / (8 * half * half * half), 1, kRounding);
  }
}

TEST(ConvexHull, IsEqualByContent) {
  EXPECT_EQ(HullBox({1, 2, 3}), HullBox({1, 2, 3}));
  EXPECT_NE(HullBox({1, 2, 3}), HullBox({1, 2, 3.1}));
  EXPECT_NE(ConvexHull{}, HullBox({1, 2, 3}));
  EXPECT_EQ(ConvexHull{}, ConvexHull{});
}

}  // namespace
}  // namespace genphys

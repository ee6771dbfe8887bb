// How surfaces turn along themselves, against closed forms and against neighbouring places of the same surface.
#include "shapes/curvature.h"

#include <gtest/gtest.h>

#include <cmath>

namespace genphys {
namespace {

constexpr double kRounding = 1e-12;

Tangents AcrossOf(const Vector3& normal) {
  Tangents tangents;
  tangents.col(0) = normal.unitOrthogonal();
  tangents.col(1) = normal.cross(tangents.col(0));
  return tangents;
}

Curvature Of(const Shape& shape, const Vector3& point, const Vector3& normal, const Tangents& tangents) {
  return CurvatureAt(shape, point, normal, tangents, false);
}

TEST(Curvature, OfABallIsThatOfItsRadius) {
  const Vector3 normal = Vector3(1, 2, -3).normalized();
  EXPECT_TRUE(Of(Sphere{0.2}, 0.2 * normal, normal, AcrossOf(normal)).isApprox(5 * Curvature::Identity(), kRounding));
}

// Where an ellipsoid has a normal n is diag(a^2) n over the length of diag(a) n.
TEST(Curvature, OfAnEllipsoidSaysWhereTheNextNormalIs) {
  const Ellipsoid shape{{0.3, 0.2, 0.1}};
  const auto place_of = [&](const Vector3& normal) -> Vector3 {
    return shape.semi_axes.cwiseAbs2().cwiseProduct(normal) / shape.semi_axes.cwiseProduct(normal).norm();
  };
  constexpr double kSmall = 1e-5;
  for (const Vector3& direction : {Vector3(0, 0, 1), Vector3(1, 2, -3), Vector3(1, 0, 0.3)}) {
    const Vector3 normal = direction.normalized();
    const Tangents tangents = AcrossOf(normal);
    const Curvature found = Of(shape, place_of(normal), normal, tangents);
    for (int i = 0; i < 2; ++i) {
      const Vector3 turned = kSmall * tangents.col(i);
      const Vector3 way = place_of((normal + turned).normalized()) - place_of((normal - turned).normalized());
      const Eigen::Vector2d told = found * (tangents.transpose() * way) / (2 * kSmall);
      EXPECT_NEAR((told - Eigen::Vector2d::Unit(i)).norm(), 0, kSmall) << direction;
    }
  }
}

TEST(Curvature, OfACylinderIsThatOfItsSideRimAndEnd) {
  const Cylinder shape{0.2, 0.5};
  const Vector3 side = Vector3::UnitX(), end = Vector3::UnitZ();
  Tangents tangents;
  tangents << Vector3::UnitY(), Vector3::UnitZ();
  Curvature wanted;
  wanted << 5, 0, 0, 0;
  EXPECT_TRUE(Of(shape, {0.2, 0, 0.1}, side, tangents).isApprox(wanted, kRounding));
  EXPECT_TRUE(Of(shape, {0.2, 0, 0.5}, end, AcrossOf(end)).isZero());
  // All normals of the rim lean alike: around it one of 30 degrees turns half as much as the edge of the end.
  const Vector3 rim(std::sin(M_PI / 6), 0, std::cos(M_PI / 6));
  tangents << Vector3::UnitY(), rim.cross(Vector3::UnitY());
  wanted << 2.5, 0, 0, kSharp;
  EXPECT_TRUE(Of(shape, {0.2, 0, 0.5}, rim, tangents).isApprox(wanted, kRounding));
  EXPECT_TRUE(CurvatureAt(shape, {0.2, 0, 0.5}, rim, tangents, true).isZero()) << "it stands on it";
}

TEST(Curvature, OfACapsuleAndAConeIsRoundAboutTheirAxis) {
  const Vector3 side = Vector3::UnitX(), up = Vector3::UnitZ();
  Tangents tangents;
  tangents << Vector3::UnitY(), Vector3::UnitZ();
  Curvature wanted;
  wanted << 5, 0, 0, 0;
  EXPECT_TRUE(Of(Capsule{0.2, 0.5}, {0.2, 0, 0.1}, side, tangents).isApprox(wanted, kRounding));
  EXPECT_TRUE(Of(Capsule{0.2, 0.5}, {0, 0, 0.7}, up, AcrossOf(up)).isApprox(5 * Curvature::Identity(), kRounding));
  // A cone of 45 degrees, half way up.
  const Vector3 lean = Vector3(1, 0, 1).normalized();
  tangents << Vector3::UnitY(), lean.cross(Vector3::UnitY());
  wanted << std::sqrt(0.5) / 0.1, 0, 0, 0;
  EXPECT_TRUE(Of(Cone{0.2, 0.1}, {0.1, 0, 0}, lean, tangents).isApprox(wanted, kRounding));
}

TEST(Curvature, OfABoxIsSharpAcrossItsEdgesAndAtItsCorners) {
  const Box shape{{0.3, 0.2, 0.1}};
  const Vector3 face = Vector3::UnitZ(), edge = Vector3(0, 1, 1).normalized(), corner = Vector3(1, 1, 1).normalized();
  Tangents tangents;
  tangents << Vector3::UnitX(), edge.cross(Vector3::UnitX());
  Curvature wanted;
  wanted << 0, 0, 0, kSharp;
  EXPECT_TRUE(Of(shape, {0.1, 0.1, 0.1}, face, AcrossOf(face)).isZero());
  EXPECT_TRUE(Of(shape, {0.1, 0.2, 0.1}, edge, tangents).isApprox(wanted, kRounding));
  EXPECT_TRUE(Of(shape, {0.3, 0.2, 0.1}, corner, AcrossOf(corner)).isApprox(kSharp * Curvature::Identity(), kRounding));
}

}  // namespace
}  // namespace genphys

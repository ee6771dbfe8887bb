#include "shapes/curvature.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace genphys {
namespace {

// The sine of an angle at which two faces or a face and a line are still level with each other.
constexpr double kLevel = 1e-4;
// The same as a loss of the cosine.
constexpr double kLevelCosine = kLevel * kLevel / 2;

struct Finder {
  const Vector3& point;
  const Vector3& normal;
  const Tangents& tangents;
  bool is_wide;

  static Curvature Round(double radius) { return Curvature::Identity() / radius; }

  // Of a curve that turns by `along` in the direction `axis`, and by `across` across it.
  Curvature Mixed(const Vector3& axis, double along, double across) const {
    const Eigen::Vector2d way = (tangents.transpose() * axis).normalized();
    return across * Curvature::Identity() + (along - across) * way * way.transpose();
  }

  // About the z axis. All normals of a circle around it lean alike (Meusnier). `across`: of what was turned about it.
  Curvature Turned(double across) const {
    const double lean = normal.head<2>().norm(), radius = point.head<2>().norm();
    if (!(lean > 0)) return across * Curvature::Identity();
    const double around = lean < kSharp * radius ? lean / radius : kSharp;
    return Mixed({-normal.y(), normal.x(), 0}, around, across);
  }

  Curvature Edged(double least, double most) const {
    const bool is_face = normal.z() > most - kLevelCosine || normal.z() < least + kLevelCosine;
    return is_face || is_wide ? Curvature(Curvature::Zero()) : Turned(kSharp);
  }

  Curvature operator()(const Sphere& sphere) const { return Round(sphere.radius); }
  Curvature operator()(const Ellipsoid& ellipsoid) const {
    const Vector3& axes = ellipsoid.semi_axes;
    const Eigen::Matrix<double, 3, 2> bent = axes.cwiseAbs2().cwiseInverse().asDiagonal() * tangents;
    return axes.cwiseProduct(normal).norm() * tangents.transpose() * bent;
  }
  Curvature operator()(const Capsule& capsule) const {
    return std::abs(normal.z()) > kLevel ? Round(capsule.radius) : Mixed(Vector3::UnitZ(), 0, 1 / capsule.radius);
  }
  Curvature operator()(const Cylinder&) const { return std::abs(normal.z()) < kLevel ? Turned(0) : Edged(-1, 1); }
  Curvature operator()(const Cone& cone) const {
    const double side = cone.radius / std::hypot(cone.radius, 2 * cone.half_length);
    return std::abs(normal.z() - side) < kLevel ? Turned(0) : Edged(-1, 2);
  }
  Curvature operator()(const Box&) const {
    const Eigen::Array3d leans = normal.array().abs();
    Eigen::Index edge = 0;
    if (leans.minCoeff(&edge) > kLevel) return kSharp * Curvature::Identity();
    if (leans.maxCoeff() > 1 - kLevelCosine) return Curvature::Zero();
    return Mixed(Vector3::Unit(edge), 0, kSharp);
  }
  Curvature operator()(const auto&) const { return Curvature::Zero(); }
};

}  // namespace

Curvature CurvatureAt(const Shape& shape, const Vector3& point, const Vector3& normal, const Tangents& tangents,
                      bool is_wide) {
  return std::visit(Finder{point, normal, tangents, is_wide}, shape);
}

}  // namespace genphys

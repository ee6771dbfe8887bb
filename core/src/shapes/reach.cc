#include "shapes/reach.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genphys/bounds.h"
#include "genphys/convex_hull.h"

namespace genphys {
namespace {

// From a point in the frame of the shape.
struct ReachOf {
  const Vector3& point;

  double across() const { return std::hypot(point.x(), point.y()); }

  double operator()(const Sphere& s) const { return point.norm() + s.radius; }
  double operator()(const Box& s) const { return (point.cwiseAbs() + s.half_extents).norm(); }
  double operator()(const Capsule& s) const {
    return std::hypot(across(), std::abs(point.z()) + s.half_length) + s.radius;
  }
  double operator()(const Cylinder& s) const {
    return std::hypot(across() + s.radius, std::abs(point.z()) + s.half_length);
  }
  double operator()(const Plane&) const { return std::numeric_limits<double>::infinity(); }
  double operator()(const Cone& s) const {
    return std::max(std::hypot(across(), s.half_length - point.z()),
                    std::hypot(across() + s.radius, s.half_length + point.z()));
  }
  // Of the box around it, or of the ball.
  double operator()(const Ellipsoid& s) const {
    return std::min(point.norm() + s.semi_axes.maxCoeff(), (point.cwiseAbs() + s.semi_axes).norm());
  }
  double operator()(const ConvexHull& s) const {
    double square = 0;
    for (const Vector3& vertex : s.data->vertices) square = std::max(square, (vertex - point).squaredNorm());
    return std::sqrt(square);
  }
  double operator()(const TriangleMesh& s) const { return point.norm() + BoundingRadius(s); }
  double operator()(const Heightfield& s) const { return point.norm() + BoundingRadius(s); }
};

}  // namespace

double ReachFrom(const Vector3& center, const Geometry& geometry) {
  const Pose& pose = geometry.pose_in_entity;
  const Vector3 point = pose.orientation.conjugate() * (center - pose.position);
  return std::visit(ReachOf{point}, geometry.shape);
}

double ReachFrom(const Vector3& center, const RigidBody& body) {
  double reach = 0;
  for (const Geometry& geometry : body.geometries) reach = std::max(reach, ReachFrom(center, geometry));
  return reach;
}

}  // namespace genphys

#include "genphys/ray_cast.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genphys/convex_hull.h"
#include "shapes/surface_triangles.h"

namespace genphys {
namespace {

using MaybeHit = std::optional<SurfaceHit>;

// By so much of its size a triangle or a tip is taken to be larger, so that no ray slips through beside it.
constexpr double kSeam = 1e-12;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where the line o + t d comes within `radius` of the origin first, in any number of dimensions. Measured from the
// point nearest to the origin, because the textbook discriminant loses a small sphere far away.
template <typename Vector>
std::optional<double> EnterBall(const Vector& o, const Vector& d, double radius) {
  const double square = d.squaredNorm();
  if (square == 0 || o.squaredNorm() < radius * radius) return std::nullopt;
  const double nearest = -o.dot(d) / square;
  if (nearest < 0) return std::nullopt;
  const double rest = radius * radius - (o + nearest * d).squaredNorm();
  if (rest < 0) return std::nullopt;
  const double fraction = std::max(0.0, nearest - std::sqrt(rest / square));
  if (fraction > 1) return std::nullopt;
  return fraction;
}

MaybeHit EnterSphere(const Vector3& center, double radius, const Ray& ray) {
  const Vector3 origin = ray.origin - center;
  const auto fraction = EnterBall(origin, ray.translation, radius);
  if (!fraction) return std::nullopt;
  return SurfaceHit{*fraction, (origin + *fraction * ray.translation).normalized()};
}

// The side of a cylinder around z, between -half_length and half_length.
MaybeHit EnterSide(double radius, double half_length, const Ray& ray) {
  const Eigen::Vector2d origin = ray.origin.head<2>();
  const Eigen::Vector2d translation = ray.translation.head<2>();
  const auto fraction = EnterBall(origin, translation, radius);
  if (!fraction || std::abs(ray.origin.z() + *fraction * ray.translation.z()) > half_length) return std::nullopt;
  const Eigen::Vector2d normal = (origin + *fraction * translation).normalized();
  return SurfaceHit{*fraction, {normal.x(), normal.y(), 0}};
}

MaybeHit Earlier(const MaybeHit& a, const MaybeHit& b) {
  if (!a || (b && b->fraction < a->fraction)) return b;
  return a;
}

MaybeHit Enter(const Sphere& sphere, const Ray& ray) { return EnterSphere(Vector3::Zero(), sphere.radius, ray); }

MaybeHit Enter(const Box& box, const Ray& ray) {
  double enter = -kInfinity;
  double leave = kInfinity;
  int enter_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = box.half_extents[axis];
    const double origin = ray.origin[axis];
    const double translation = ray.translation[axis];
    if (translation == 0) {
      if (std::abs(origin) > half) return std::nullopt;
      continue;
    }
    const double side = translation > 0 ? half : -half;
    const double first = (-side - origin) / translation;
    if (first > enter) {
      enter = first;
      enter_axis = axis;
    }
    leave = std::min(leave, (side - origin) / translation);
  }
  // From inside, all entries lie behind.
  if (enter < 0 || enter > 1 || enter > leave) return std::nullopt;
  return SurfaceHit{enter, Vector3::Unit(enter_axis) * (ray.translation[enter_axis] > 0 ? -1.0 : 1.0)};
}

MaybeHit Enter(const Capsule& capsule, const Ray& ray) {
  const Vector3& o = ray.origin;
  const Vector3 on_axis(0, 0, std::clamp(o.z(), -capsule.half_length, capsule.half_length));
  if ((o - on_axis).squaredNorm() < capsule.radius * capsule.radius) return std::nullopt;
  // From outside, the union of the three solids is entered where the first of them is.
  const Vector3 top(0, 0, capsule.half_length);
  return Earlier(EnterSide(capsule.radius, capsule.half_length, ray),
                 Earlier(EnterSphere(top, capsule.radius, ray), EnterSphere(-top, capsule.radius, ray)));
}

MaybeHit Enter(const Cylinder& cylinder, const Ray& ray) {
  const double from_outside = std::abs(ray.origin.z()) - cylinder.half_length;
  const double towards = ray.origin.z() > 0 ? -ray.translation.z() : ray.translation.z();
  if (from_outside >= 0 && towards > 0 && from_outside <= towards) {
    const double fraction = from_outside / towards;
    const Eigen::Vector2d point = ray.origin.head<2>() + fraction * ray.translation.head<2>();
    if (point.squaredNorm() <= cylinder.radius * cylinder.radius) {
      return SurfaceHit{fraction, {0, 0, ray.origin.z() > 0 ? 1.0 : -1.0}};
    }
  }
  return EnterSide(cylinder.radius, cylinder.half_length, ray);
}

MaybeHit Enter(const Plane& plane, const Ray& ray) {
  const double height = plane.normal.dot(ray.origin) - plane.offset;
  const double descent = -plane.normal.dot(ray.translation);
  if (height < 0 || descent <= 0 || height > descent) return std::nullopt;
  return SurfaceHit{height / descent, plane.normal};
}

MaybeHit Enter(const Ellipsoid& ellipsoid, const Ray& ray) {
  // Where all axes are one long, it is a ball.
  const Vector3 origin = ray.origin.cwiseQuotient(ellipsoid.semi_axes);
  const Vector3 translation = ray.translation.cwiseQuotient(ellipsoid.semi_axes);
  const auto fraction = EnterBall(origin, translation, 1.0);
  if (!fraction) return std::nullopt;
  return SurfaceHit{*fraction, (origin + *fraction * translation).cwiseQuotient(ellipsoid.semi_axes).normalized()};
}

// The round side: x^2 + y^2 = (slope z)^2 with z measured from the apex.
MaybeHit EnterSlope(const Cone& cone, const Ray& ray) {
  const double slope = cone.radius / (2 * cone.half_length), square = slope * slope;
  const Vector3& d = ray.translation;
  if (d.isZero(0)) return std::nullopt;
  // Measured from the point nearest to the cone, for the same reason as with balls.
  const double nearest = -ray.origin.dot(d) / d.squaredNorm();
  const Vector3 o = ray.origin + nearest * d - Vector3(0, 0, cone.half_length);
  const double a = d.head<2>().squaredNorm() - square * d.z() * d.z();
  const double b = o.head<2>().dot(d.head<2>()) - square * o.z() * d.z();
  const double c = o.head<2>().squaredNorm() - square * o.z() * o.z();
  // b^2 - a c without what cancels in it, so that a ray along the axis does not miss the apex.
  const Eigen::Vector2d across = o.z() * d.head<2>() - d.z() * o.head<2>();
  const double aside = o.x() * d.y() - o.y() * d.x();
  const double discriminant = square * across.squaredNorm() - aside * aside;
  if (discriminant < 0) return std::nullopt;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  MaybeHit best;
  for (const double from_nearest : {q / a, c / q}) {
    const double fraction = nearest + from_nearest;
    const Vector3 p = o + from_nearest * d;
    if (!(fraction >= 0 && fraction <= 1) || !(p.z() <= kSeam * cone.half_length && p.z() >= -2 * cone.half_length))
      continue;
    Vector3 normal(p.x(), p.y(), -square * p.z());
    // The very apex faces all sides.
    if (p.norm() <= kSeam * cone.half_length) normal = Vector3::UnitZ();
    normal.normalize();
    if (!(normal.dot(d) < 0) || (best && best->fraction <= fraction)) continue;
    best = SurfaceHit{fraction, normal};
  }
  return best;
}

MaybeHit Enter(const Cone& cone, const Ray& ray) {
  const double below = -cone.half_length - ray.origin.z();
  if (below >= 0 && ray.translation.z() > 0 && below <= ray.translation.z()) {
    const double fraction = below / ray.translation.z();
    const Eigen::Vector2d point = ray.origin.head<2>() + fraction * ray.translation.head<2>();
    if (point.squaredNorm() <= cone.radius * cone.radius) return SurfaceHit{fraction, -Vector3::UnitZ()};
  }
  return EnterSlope(cone, ray);
}

MaybeHit Enter(const ConvexHull& hull, const Ray& ray) {
  double enter = -kInfinity, leave = kInfinity;
  Vector3 normal = Vector3::Zero();
  for (const HullData::Face& face : hull.data->faces) {
    const double height = face.normal.dot(ray.origin) - face.offset, descent = -face.normal.dot(ray.translation);
    if (descent == 0) {
      if (height > 0) return std::nullopt;
    } else if (descent < 0) {
      leave = std::min(leave, height / descent);
    } else if (height / descent > enter) {
      enter = height / descent;
      normal = face.normal;
    }
  }
  if (!(enter >= 0 && enter <= 1 && enter <= leave)) return std::nullopt;
  return SurfaceHit{enter, normal};
}

// From its front alone (T. Moeller and B. Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997).
MaybeHit EnterTriangle(const SurfaceTriangle& triangle, const Ray& ray) {
  const Vector3 area = triangle.AreaVector();
  const double descent = -area.dot(ray.translation);
  const double height = area.dot(ray.origin - triangle.corners[0]);
  if (!(descent > 0) || height < 0 || height > descent) return std::nullopt;
  const double fraction = height / descent;
  const Vector3 point = ray.origin + fraction * ray.translation;
  for (size_t i = 0; i < 3; ++i) {
    const Vector3& from = triangle.corners[i];
    const Vector3& to = triangle.corners[(i + 1) % 3];
    if ((to - from).cross(point - from).dot(area) < -kSeam * area.squaredNorm()) return std::nullopt;
  }
  return SurfaceHit{fraction, area.normalized()};
}

// Whether the first `fraction` of the ray meets the box, with something for rounding.
bool Meets(const Bounds& box, const Ray& ray, double fraction) {
  const double slack = kSeam * (box.max - box.min).maxCoeff();
  double enter = 0, leave = fraction;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min[axis] - slack - ray.origin[axis], high = box.max[axis] + slack - ray.origin[axis];
    const double step = ray.translation[axis];
    if (step == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    enter = std::max(enter, std::min(low / step, high / step));
    leave = std::min(leave, std::max(low / step, high / step));
  }
  return enter <= leave;
}

template <typename Surface>
MaybeHit EnterSurface(const Surface& surface, const Ray& ray) {
  MaybeHit best;
  VisitTriangles(
      surface, [&](const Bounds& box) { return Meets(box, ray, best ? best->fraction : 1); },
      [&](const SurfaceTriangle& triangle) { best = Earlier(best, EnterTriangle(triangle, ray)); });
  return best;
}

MaybeHit Enter(const TriangleMesh& mesh, const Ray& ray) { return EnterSurface(*mesh.data, ray); }
MaybeHit Enter(const Heightfield& field, const Ray& ray) { return EnterSurface(*field.data, ray); }

}  // namespace

std::optional<SurfaceHit> EnterShape(const Shape& shape, const Ray& ray) {
  return std::visit([&](const auto& solid) { return Enter(solid, ray); }, shape);
}

}  // namespace genphys

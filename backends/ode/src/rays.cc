// Closed forms, rather than ODE's own ray geometry: that one takes rays from inside for hits, and needs a geometry of
// its own, which a query would have to share or to allocate.
#include "rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace genphys::ode_backend {
namespace {

using MaybeEntry = std::optional<Entry>;

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

MaybeEntry EnterSphere(const Vector3& center, double radius, const Ray& ray) {
  const Vector3 origin = ray.origin - center;
  const auto fraction = EnterBall(origin, ray.translation, radius);
  if (!fraction) return std::nullopt;
  return Entry{*fraction, (origin + *fraction * ray.translation).normalized()};
}

// The side of a cylinder around z, between -half_length and half_length.
MaybeEntry EnterSide(double radius, double half_length, const Ray& ray) {
  const Eigen::Vector2d origin = ray.origin.head<2>();
  const Eigen::Vector2d translation = ray.translation.head<2>();
  const auto fraction = EnterBall(origin, translation, radius);
  if (!fraction || std::abs(ray.origin.z() + *fraction * ray.translation.z()) > half_length) return std::nullopt;
  const Eigen::Vector2d normal = (origin + *fraction * translation).normalized();
  return Entry{*fraction, {normal.x(), normal.y(), 0}};
}

MaybeEntry Earlier(const MaybeEntry& a, const MaybeEntry& b) {
  if (!a || (b && b->fraction < a->fraction)) return b;
  return a;
}

MaybeEntry Enter(const Sphere& sphere, const Ray& ray) { return EnterSphere(Vector3::Zero(), sphere.radius, ray); }

MaybeEntry Enter(const Box& box, const Ray& ray) {
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
  return Entry{enter, Vector3::Unit(enter_axis) * (ray.translation[enter_axis] > 0 ? -1.0 : 1.0)};
}

MaybeEntry Enter(const Capsule& capsule, const Ray& ray) {
  const Vector3& o = ray.origin;
  const Vector3 on_axis(0, 0, std::clamp(o.z(), -capsule.half_length, capsule.half_length));
  if ((o - on_axis).squaredNorm() < capsule.radius * capsule.radius) return std::nullopt;
  // From outside, the union of the three solids is entered where the first of them is.
  const Vector3 top(0, 0, capsule.half_length);
  return Earlier(EnterSide(capsule.radius, capsule.half_length, ray),
                 Earlier(EnterSphere(top, capsule.radius, ray), EnterSphere(-top, capsule.radius, ray)));
}

MaybeEntry Enter(const Cylinder& cylinder, const Ray& ray) {
  const double from_outside = std::abs(ray.origin.z()) - cylinder.half_length;
  const double towards = ray.origin.z() > 0 ? -ray.translation.z() : ray.translation.z();
  if (from_outside >= 0 && towards > 0 && from_outside <= towards) {
    const double fraction = from_outside / towards;
    const Eigen::Vector2d point = ray.origin.head<2>() + fraction * ray.translation.head<2>();
    if (point.squaredNorm() <= cylinder.radius * cylinder.radius) {
      return Entry{fraction, {0, 0, ray.origin.z() > 0 ? 1.0 : -1.0}};
    }
  }
  return EnterSide(cylinder.radius, cylinder.half_length, ray);
}

MaybeEntry Enter(const Plane& plane, const Ray& ray) {
  const double height = plane.normal.dot(ray.origin) - plane.offset;
  const double descent = -plane.normal.dot(ray.translation);
  if (height < 0 || descent <= 0 || height > descent) return std::nullopt;
  return Entry{height / descent, plane.normal};
}

}  // namespace

std::optional<Entry> EnterShape(const Shape& shape, const Ray& ray) {
  return std::visit([&](const auto& solid) { return Enter(solid, ray); }, shape);
}

}  // namespace genphys::ode_backend

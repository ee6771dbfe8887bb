#include "shapes/solid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "genphys/bounds.h"
#include "genphys/convex_hull.h"
#include "genphys/inertia.h"
#include "genphys/work_watch.h"

namespace genphys {
namespace {

// Corners of the polygon that stands for a round rim.
constexpr int kRimCorners = 8;
// Up to this sine what leans leans nowhere.
constexpr double kNoTilt = 1e-5;
// Up to this one a round end stands, and sways: its corners are where they are in its frame, whichever way it leans, or
// a solve would not find what held it before. The deepest point of the rim is then missed by less than 8e-5 radii. (Ten
// discs on each other fell in five seconds when corners turned with the lean.)
constexpr double kStanding = 1e-3;
// Vertices up to which a hull is searched by looking at all.
constexpr size_t kScanMax = 48;

Vector3 FarthestOn(const Sphere&, const Vector3&) { return Vector3::Zero(); }
Vector3 FarthestOn(const Box& box, const Vector3& d) {
  return (d.array() < 0).select(-box.half_extents, box.half_extents);
}
Vector3 FarthestOn(const Capsule& capsule, const Vector3& d) {
  return {0, 0, std::copysign(capsule.half_length, d.z())};
}

Vector3 OnRim(double radius, double z, const Vector3& d) {
  const double across = d.head<2>().norm();
  const double scale = across > 0 ? radius / across : 0;
  return {scale * d.x(), scale * d.y(), z};
}

Vector3 FarthestOn(const Cylinder& cylinder, const Vector3& d) {
  return OnRim(cylinder.radius, std::copysign(cylinder.half_length, d.z()), d);
}
Vector3 FarthestOn(const Cone& cone, const Vector3& d) {
  const bool is_apex = 2 * cone.half_length * d.z() > cone.radius * d.head<2>().norm();
  return is_apex ? Vector3(0, 0, cone.half_length) : OnRim(cone.radius, -cone.half_length, d);
}
Vector3 FarthestOn(const Ellipsoid& ellipsoid, const Vector3& d) {
  // Scaled first, lest the square of a small number be nothing.
  const Vector3 scaled = ellipsoid.semi_axes.cwiseProduct(d / d.cwiseAbs().maxCoeff());
  return ellipsoid.semi_axes.cwiseProduct(scaled) / scaled.norm();
}

uint32_t FarthestVertex(const HullData& hull, const Vector3& d) {
  uint32_t best = 0;
  double farthest = d.dot(hull.vertices[0]);
  const auto look_at = [&](uint32_t vertex) {
    const double along = d.dot(hull.vertices[vertex]);
    if (along <= farthest) return false;
    farthest = along;
    best = vertex;
    return true;
  };
  if (hull.vertices.size() <= kScanMax) {
    WorkWatch::Look(static_cast<int64_t>(hull.vertices.size()));
    for (uint32_t vertex = 1; vertex < hull.vertices.size(); ++vertex) look_at(vertex);
    return best;
  }
  // On a convex body a vertex that no neighbour outdoes is outdone by none.
  for (bool is_higher = true; is_higher;) {
    is_higher = false;
    const uint32_t here = best;
    WorkWatch::Look(hull.neighbor_first[here + 1] - hull.neighbor_first[here]);
    for (uint32_t i = hull.neighbor_first[here]; i < hull.neighbor_first[here + 1]; ++i) {
      is_higher |= look_at(hull.neighbors[i]);
    }
  }
  return best;
}

Vector3 FarthestOn(const ConvexHull& hull, const Vector3& d) {
  return hull.data->vertices[FarthestVertex(*hull.data, d)];
}
// These are no solids: whoever asks has checked it.
Vector3 FarthestOn(const Plane&, const Vector3&) { return Vector3::Zero(); }
Vector3 FarthestOn(const TriangleMesh&, const Vector3&) { return Vector3::Zero(); }
Vector3 FarthestOn(const Heightfield&, const Vector3&) { return Vector3::Zero(); }

Farthest Staying(const Vector3& point) { return {point, Eigen::Matrix2d::Zero()}; }

Farthest FollowRim(double radius, double z, const Vector3& d, const AxesAcross& across) {
  const double lean = d.head<2>().norm();
  const Eigen::Vector2d around = across.transpose() * Vector3(-d.y(), d.x(), 0) / lean;
  return {OnRim(radius, z, d), radius / lean * around * around.transpose()};
}

template <typename Cornered>
Farthest FollowOn(const Cornered&, const Vector3& point, const Vector3&, const AxesAcross&) {
  return Staying(point);
}
Farthest FollowOn(const Cylinder& cylinder, const Vector3& point, const Vector3& d, const AxesAcross& across) {
  return FollowRim(cylinder.radius, std::copysign(cylinder.half_length, point.z()), d, across);
}
Farthest FollowOn(const Cone& cone, const Vector3& point, const Vector3& d, const AxesAcross& across) {
  return point.z() > 0 ? Staying({0, 0, cone.half_length}) : FollowRim(cone.radius, -cone.half_length, d, across);
}
Farthest FollowOn(const Ellipsoid& ellipsoid, const Vector3&, const Vector3& d, const AxesAcross& across) {
  const AxesAcross scaled = ellipsoid.semi_axes.asDiagonal() * across;
  const double reach = ellipsoid.semi_axes.cwiseProduct(d).norm();
  const Vector3 point = ellipsoid.semi_axes.cwiseAbs2().cwiseProduct(d) / reach;
  const Eigen::Vector2d beside = across.transpose() * point;
  return {point, (scaled.transpose() * scaled - beside * beside.transpose()) / reach};
}

// In the frame of the shape.
SolidFeature Point(const Vector3& point) { return {.corners = {point}}; }

SolidFeature FeatureOf(const Box& box, const Vector3& d) {
  int axis = 0;
  d.cwiseAbs().maxCoeff(&axis);
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  const double side = d[axis] < 0 ? -1 : 1;
  SolidFeature feature{.normal = side * Vector3::Unit(axis)};
  for (const auto& [u, v] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}) {
    Vector3 corner;
    corner[axis] = side * box.half_extents[axis];
    corner[next] = u * box.half_extents[next];
    corner[last] = v * box.half_extents[last];
    feature.corners.push_back(corner);
  }
  return feature;
}

// The direction across z in which `d` leans, x if it does not.
Vector3 Outward(const Vector3& d) {
  const double across = std::hypot(d.x(), d.y());
  return across < kNoTilt ? Vector3(Vector3::UnitX()) : Vector3(d.x() / across, d.y() / across, 0);
}

// The end of a solid of which `d` faces something. Of its rim one corner lies farthest, unless it stands.
SolidFeature Disc(double radius, double z, const Vector3& d, double side) {
  SolidFeature feature{.normal = side * Vector3::UnitZ()};
  const double lean = std::hypot(d.x(), d.y());
  const double first = lean < kStanding ? 0 : std::atan2(d.y(), d.x());
  for (int i = 0; i < kRimCorners; ++i) {
    const double angle = first + 2 * std::numbers::pi * i / kRimCorners;
    feature.corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return feature;
}

SolidFeature FeatureOf(const Cylinder& cylinder, const Vector3& d) {
  const Vector3 outward = Outward(d);
  if (std::abs(d.z()) < std::numbers::sqrt2 / 2) {
    const Vector3 half(0, 0, cylinder.half_length);
    return {.corners = {cylinder.radius * outward + half, cylinder.radius * outward - half}};
  }
  const double side = d.z() < 0 ? -1 : 1;
  return Disc(cylinder.radius, side * cylinder.half_length, d, side);
}

SolidFeature FeatureOf(const Cone& cone, const Vector3& d) {
  const Vector3 outward = Outward(d);
  const Eigen::Vector2d slope = Eigen::Vector2d(2 * cone.half_length, cone.radius).normalized();
  if (-d.z() > slope.x() * outward.dot(d) + slope.y() * d.z()) {
    return Disc(cone.radius, -cone.half_length, d, -1);
  }
  return {.corners = {Vector3(0, 0, cone.half_length), cone.radius * outward - Vector3(0, 0, cone.half_length)}};
}

SolidFeature FeatureOf(const ConvexHull& hull, const Vector3& d) {
  const HullData& data = *hull.data;
  const uint32_t vertex = FarthestVertex(data, d);
  const HullData::Face* best = nullptr;
  for (uint32_t i = data.vertex_face_first[vertex]; i < data.vertex_face_first[vertex + 1]; ++i) {
    const HullData::Face& face = data.faces[data.vertex_faces[i]];
    if (best == nullptr || face.normal.dot(d) > best->normal.dot(d)) best = &face;
  }
  SolidFeature feature{.normal = best->normal};
  WorkWatch::Look(data.vertex_face_first[vertex + 1] - data.vertex_face_first[vertex] + best->count);
  for (const uint32_t corner : data.CornersOf(*best)) feature.corners.push_back(data.vertices[corner]);
  return feature;
}

SolidFeature FeatureOf(const Capsule& capsule, const Vector3&) {
  const Vector3 half(0, 0, capsule.half_length);
  return {.corners = {half, -half}};
}

template <typename Pointed>
SolidFeature FeatureOf(const Pointed& shape, const Vector3& d) {
  return Point(FarthestOn(shape, d));
}

}  // namespace

Solid::Solid(const Shape& shape, const Placement& placement)
    : shape_(&shape),
      placement_(placement),
      center_(placement.Transform(genphys::CenterOfMass(shape))),
      size_(SmallestHalfExtent(shape)),
      is_round_(std::holds_alternative<Cylinder>(shape) || std::holds_alternative<Cone>(shape) ||
                std::holds_alternative<Ellipsoid>(shape)) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) radius_ = sphere->radius;
  if (const auto* capsule = std::get_if<Capsule>(&shape)) radius_ = capsule->radius;
}

Solid::Solid(const SurfaceTriangle& triangle) : triangle_(&triangle) {
  const auto& [a, b, c] = triangle.corners;
  center_ = (a + b + c) / 3;
  size_ = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
}

Solid::Solid(const SurfaceTriangle& triangle, double drop) : Solid(triangle) {
  drop_ = drop;
  center_.z() -= drop / 2;
}

Vector3 Solid::Support(const Vector3& direction) const {
  if (triangle_ != nullptr) {
    const auto& [a, b, c] = triangle_->corners;
    const double along_a = direction.dot(a), along_b = direction.dot(b), along_c = direction.dot(c);
    Vector3 farthest = along_a >= along_b ? (along_a >= along_c ? a : c) : (along_b >= along_c ? b : c);
    if (direction.z() < 0) farthest.z() -= drop_;
    return farthest;
  }
  const Vector3 local = placement_.rotation.transpose() * direction;
  return placement_.Transform(std::visit([&](const auto& s) { return FarthestOn(s, local); }, *shape_));
}

Farthest Solid::Follow(const Vector3& point, const Vector3& direction, const AxesAcross& across) const {
  if (!is_round_) return Staying(point);
  const Vector3 here = placement_.ToLocal(point), local = placement_.rotation.transpose() * direction;
  const AxesAcross local_across = placement_.rotation.transpose() * across;
  Farthest found = std::visit([&](const auto& shape) { return FollowOn(shape, here, local, local_across); }, *shape_);
  found.point = placement_.Transform(found.point);
  return found;
}

SolidFeature Solid::FeatureAt(const Vector3& direction) const {
  if (triangle_ != nullptr) {
    const Vector3 normal = triangle_->AreaVector().normalized();
    const double side = normal.dot(direction) < 0 ? -1 : 1;
    return {.corners = {triangle_->corners.begin(), triangle_->corners.end()}, .normal = side * normal};
  }
  const Vector3 local = placement_.rotation.transpose() * direction;
  SolidFeature feature = std::visit([&](const auto& s) { return FeatureOf(s, local); }, *shape_);
  for (Vector3& corner : feature.corners) corner = placement_.Transform(corner);
  feature.normal = placement_.rotation * feature.normal;
  return feature;
}

size_t Solid::Normals(const Vector3& other, std::array<Vector3, kNormalsMax>& normals) const {
  size_t count = 0;
  const auto add = [&](const Vector3& local) {
    if (count < kNormalsMax) normals[count++] = placement_.rotation * local;
  };
  if (triangle_ != nullptr) {
    normals[0] = triangle_->AreaVector().normalized();
    normals[1] = -normals[0];
    return 2;
  }
  if (const auto* hull = std::get_if<ConvexHull>(shape_)) {
    // The largest come first.
    for (const HullData::Face& face : hull->data->faces) add(face.normal);
    return count;
  }
  for (int axis = 0; axis < 3; ++axis) {
    add(Vector3::Unit(axis));
    add(-Vector3::Unit(axis));
  }
  const Vector3 local = placement_.ToLocal(other);
  const Vector3 outward = Outward(local.normalized());
  add(outward);
  if (const auto* cone = std::get_if<Cone>(shape_)) {
    add((2 * cone->half_length * outward + cone->radius * Vector3::UnitZ()).normalized());
  }
  return count;
}

}  // namespace genphys

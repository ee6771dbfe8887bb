#include "genphys/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"
#include "shapes/surface_triangles.h"

namespace genphys {
namespace {

// Vertices up to which the bounds of a hull are those of its vertices, and not of its own box.
constexpr size_t kVerticesMax = 64;

Bounds Around(const Placement& placement, const Vector3& extent) {
  return {placement.position - extent, placement.position + extent};
}

// Of a box in the frame of the placement.
Bounds Moved(const Bounds& box, const Placement& placement) {
  const Vector3 middle = placement.Transform((box.min + box.max) / 2);
  const Vector3 extent = placement.rotation.cwiseAbs() * ((box.max - box.min) / 2);
  return {middle - extent, middle + extent};
}

// Half the width of a disc across `axis`, along each axis of the world.
Vector3 DiscExtent(double radius, const Vector3& axis) { return radius * (1 - axis.array().square()).max(0).sqrt(); }

struct BoundsAt {
  const Placement& placement;

  Bounds operator()(const Sphere& s) const { return Around(placement, Vector3::Constant(s.radius)); }
  Bounds operator()(const Box& s) const { return Around(placement, placement.rotation.cwiseAbs() * s.half_extents); }
  Bounds operator()(const Capsule& s) const {
    return Around(placement, (s.half_length * placement.rotation.col(2).cwiseAbs()).array() + s.radius);
  }
  Bounds operator()(const Cylinder& s) const {
    const Vector3 axis = placement.rotation.col(2);
    return Around(placement, s.half_length * axis.cwiseAbs() + DiscExtent(s.radius, axis));
  }
  Bounds operator()(const Plane&) const {
    return Around({}, Vector3::Constant(std::numeric_limits<double>::infinity()));
  }
  Bounds operator()(const Cone& s) const {
    const Vector3 half = s.half_length * placement.rotation.col(2);
    const Vector3 disc = DiscExtent(s.radius, placement.rotation.col(2));
    const Vector3 apex = placement.position + half, base = placement.position - half;
    return {apex.cwiseMin(base - disc), apex.cwiseMax(base + disc)};
  }
  Bounds operator()(const Ellipsoid& s) const {
    return Around(placement, (placement.rotation * s.semi_axes.asDiagonal()).rowwise().norm());
  }
  Bounds operator()(const ConvexHull& s) const {
    if (s.data->vertices.size() > kVerticesMax) return Moved({s.data->low, s.data->high}, placement);
    const Vector3 first = placement.Transform(s.data->vertices.front());
    Bounds bounds{first, first};
    for (const Vector3& vertex : s.data->vertices) {
      const Vector3 p = placement.Transform(vertex);
      bounds = bounds.Union({p, p});
    }
    return bounds;
  }
  Bounds operator()(const TriangleMesh& s) const { return Moved(genphys::BoundsOf(*s.data), placement); }
  Bounds operator()(const Heightfield& s) const {
    // What has sunk in is still to be found: as deep as the field is wide.
    Bounds box = genphys::BoundsOf(*s.data);
    box.min.z() -= (box.max - box.min).maxCoeff();
    return Moved(box, placement);
  }
};

struct HalfExtentOf {
  double operator()(const Sphere& s) const { return s.radius; }
  double operator()(const Box& s) const { return s.half_extents.minCoeff(); }
  double operator()(const Capsule& s) const { return s.radius; }
  double operator()(const Cylinder& s) const { return std::min(s.radius, s.half_length); }
  double operator()(const Plane&) const { return std::numeric_limits<double>::infinity(); }
  double operator()(const Cone& s) const { return std::min(s.radius, s.half_length); }
  double operator()(const Ellipsoid& s) const { return s.semi_axes.minCoeff(); }
  double operator()(const ConvexHull& s) const { return s.data->thickness / 2; }
  double operator()(const TriangleMesh& s) const {
    const Bounds bounds = genphys::BoundsOf(*s.data);
    return (bounds.max - bounds.min).maxCoeff() / 10;
  }
  double operator()(const Heightfield& s) const { return s.data->cell_size; }
};

double FarthestCorner(const Bounds& box) { return box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).norm(); }

struct RadiusOf {
  double operator()(const Sphere& s) const { return s.radius; }
  double operator()(const Box& s) const { return s.half_extents.norm(); }
  double operator()(const Capsule& s) const { return s.half_length + s.radius; }
  double operator()(const Cylinder& s) const { return std::hypot(s.half_length, s.radius); }
  double operator()(const Plane&) const { return std::numeric_limits<double>::infinity(); }
  double operator()(const Cone& s) const { return std::hypot(s.half_length, s.radius); }
  double operator()(const Ellipsoid& s) const { return s.semi_axes.maxCoeff(); }
  double operator()(const ConvexHull& s) const { return FarthestCorner({s.data->low, s.data->high}); }
  double operator()(const TriangleMesh& s) const { return FarthestCorner(genphys::BoundsOf(*s.data)); }
  double operator()(const Heightfield& s) const { return FarthestCorner(genphys::BoundsOf(*s.data)); }
};

}  // namespace

Bounds BoundsOf(const Shape& shape, const Placement& placement) { return std::visit(BoundsAt{placement}, shape); }

double BoundingRadius(const Shape& shape) { return std::visit(RadiusOf{}, shape); }

double SmallestHalfExtent(const Shape& shape) { return std::visit(HalfExtentOf{}, shape); }

bool IsSurface(const Shape& shape) {
  return std::holds_alternative<TriangleMesh>(shape) || std::holds_alternative<Heightfield>(shape);
}

bool IsConvex(const Shape& shape) { return !IsSurface(shape) && !std::holds_alternative<Plane>(shape); }

}  // namespace genphys

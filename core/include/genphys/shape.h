#pragma once
#include <memory>
#include <variant>

#include "genphys/math.h"

namespace genphys {

struct HullData;
struct MeshData;
struct HeightfieldData;

/// Centred at the origin of its frame.
struct Sphere {
  double radius = 0.5;  // m
  bool operator==(const Sphere&) const = default;
};

/// Centred at the origin, edges along the axes of its frame.
struct Box {
  Vector3 half_extents{0.5, 0.5, 0.5};  // m
  bool operator==(const Box& o) const { return half_extents == o.half_extents; }
};

/// A cylinder of length 2 * half_length along local z, capped by hemispheres.
struct Capsule {
  double radius = 0.5;       // m
  double half_length = 0.5;  // m, of the straight part
  bool operator==(const Capsule&) const = default;
};

/// A cylinder of length 2 * half_length along local z.
struct Cylinder {
  double radius = 0.5;       // m
  double half_length = 0.5;  // m
  bool operator==(const Cylinder&) const = default;
};

/// All points p with dot(normal, p) <= offset are solid. Only static entities may have one.
struct Plane {
  Vector3 normal = Vector3::UnitZ();  // unit length
  double offset = 0;                  // m
  bool operator==(const Plane& o) const { return normal == o.normal && offset == o.offset; }
};

/// Apex at (0, 0, half_length), base across -half_length: the origin is at half its height, the centre of mass at
/// z = -half_length / 2.
struct Cone {
  double radius = 0.5;       // of the base, m
  double half_length = 0.5;  // m
  bool operator==(const Cone&) const = default;
};

/// Centred at the origin, axes along those of its frame.
struct Ellipsoid {
  Vector3 semi_axes{0.5, 0.5, 0.5};  // m
  bool operator==(const Ellipsoid& o) const { return semi_axes == o.semi_axes; }
};

/// The smallest convex body around points: see MakeConvexHull() in convex_hull.h. Copies share the data.
struct ConvexHull {
  std::shared_ptr<const HullData> data;  // null: not a shape yet
  bool operator==(const ConvexHull& o) const;
};

/// A surface of triangles, solid on the side from which they are seen clockwise: see MakeTriangleMesh() in surface.h.
/// Only static and kinematic entities may have one. Copies share the data.
struct TriangleMesh {
  std::shared_ptr<const MeshData> data;  // null: not a shape yet
  bool operator==(const TriangleMesh& o) const;
};

/// A surface over a grid in the local x-y plane, solid below: see MakeHeightfield() in surface.h. Only static and
/// kinematic entities may have one. Copies share the data.
struct Heightfield {
  std::shared_ptr<const HeightfieldData> data;  // null: not a shape yet
  bool operator==(const Heightfield& o) const;
};

using Shape =
    std::variant<Sphere, Box, Capsule, Cylinder, Plane, Cone, Ellipsoid, ConvexHull, TriangleMesh, Heightfield>;

/// Whether `shape` is bounded and convex.
bool IsConvex(const Shape& shape);
/// Whether `shape` is a triangle mesh or a heightfield.
bool IsSurface(const Shape& shape);

}  // namespace genphys

#pragma once
#include <variant>

#include "genphys/math.h"

namespace genphys {

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

using Shape = std::variant<Sphere, Box, Capsule, Cylinder, Plane>;

}  // namespace genphys

#pragma once
#include <array>
#include <cstddef>
#include <limits>

#include "genphys/math.h"

namespace genphys {

/// A point of the difference of the cores of two solids.
struct Corner {
  Vector3 point;  // on a less on b
  Vector3 on_a;
  Vector3 on_b;
};

/// Up to four corners, the last of which may be new.
struct Simplex {
  std::array<Corner, 4> corners;
  size_t count = 0;
};

/// The point of the hull of a simplex that is closest to the origin. Without corners the cores overlap.
struct Nearest {
  Simplex simplex;                                            // of up to three corners, all of which make it up
  std::array<double, 3> weights{};                            // of these
  Vector3 closest = Vector3::Zero();                          // m
  double distance = std::numeric_limits<double>::infinity();  // m, its length

  bool overlaps() const { return simplex.count == 0; }
  /// Unit length, from a to b, unless they overlap.
  Vector3 normal() const { return -closest / distance; }
  /// Of that part of the corners what makes up the closest point.
  Vector3 Sum(Vector3 Corner::*part) const {
    Vector3 sum = Vector3::Zero();
    for (size_t i = 0; i < simplex.count; ++i) sum += weights[i] * simplex.corners[i].*part;
    return sum;
  }
};

}  // namespace genphys

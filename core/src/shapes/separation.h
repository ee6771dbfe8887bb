#pragma once
#include <optional>

#include "shapes/gjk.h"

namespace genphys {

/// How two solids lie to each other: the direction in which the least motion parts them, or in which the gap between
/// them is.
struct Separation {
  Vector3 normal = Vector3::UnitZ();  // unit length, from a to b
  double depth = 0;                 // by how much b would have to move along the normal to leave a; negative: a gap, m
  Vector3 place = Vector3::Zero();  // half-way between the surfaces, where they are closest or deepest
};

/// By how much `b` would have to move along `direction` (unit length) to leave `a`, m.
inline double OverlapAlong(const Solid& a, const Solid& b, const Vector3& direction) {
  return a.Reach(direction) + b.Reach(-direction);
}

/// Exact for solids apart. Of solids that overlap it is a motion that no small turn of the normal makes less, found
/// from smaller copies of them where these are apart, else from the directions of their faces. Of what is farther apart
/// than `gap_max` (m) it is only told that the gap is wider.
Separation FindSeparation(const Solid& a, const Solid& b, double gap_max = std::numeric_limits<double>::infinity());

/// The separation of solids apart, or nothing if they are too near to each other for that to be exact.
std::optional<Separation> SeparationApart(const Solid& a, const Solid& b,
                                          double gap_max = std::numeric_limits<double>::infinity());

/// The separation to which small turns lead from the direction `start` (unit length).
Separation Descend(const Solid& a, const Solid& b, const Vector3& start);

/// The separation of an overlap that is shallow, from smaller copies of the solids; nothing if those overlap too.
std::optional<Separation> ShallowSeparation(const Solid& a, const Solid& b);

}  // namespace genphys

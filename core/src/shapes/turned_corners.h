#pragma once
#include <optional>

#include "shapes/gjk.h"

namespace genphys {

/// Takes the corners of `nearest` along the smooth pieces of the surfaces on which they lie, at least one of which is
/// round, to where the hull of these pieces is closest to the origin: chords of what is round come nearer to that only
/// little by little, and Newton's method on the normal and the weights at once. False, and nothing done: it does not
/// come nearer, or other pieces are closer.
bool TurnCorners(const Solid& a, const Solid& b, const CoreQuery& query, Nearest& nearest);

/// A direction along which no small turn lessens the overlap of two cores, or the one along which they are nearest.
struct LeastOverlap {
  Vector3 normal;  // from a to b
  Vector3 on_a;    // where they are deepest in each other, or nearest
  Vector3 on_b;
  double depth = 0;  // m, along the normal; negative: a gap
};

/// The one that is among the pieces on which the corners of `nearest` lie, which answered `query`, if it is.
std::optional<LeastOverlap> TurnToLeast(const Solid& a, const Solid& b, const CoreQuery& query, const Nearest& nearest);

}  // namespace genphys

#pragma once
#include <optional>

#include "genphys/entity.h"
#include "impacts/impact_motion.h"

namespace genphys {

/// A geometry that goes and turns with its body.
struct TurningGeometry {
  const ImpactMotion& motion;  // of its body
  const Geometry& geometry;
  double reach = 0;  // m, from the point of the body about which it turns to all of the geometry; zero: it has no end
};

/// Two that were apart and meet.
struct TurnedMeeting {
  double time = 0;                     // s before the end; they are hardly apart then
  Vector3 normal = Vector3::Zero();    // out of b, unit length
  Vector3 position = Vector3::Zero();  // of b, next to a
};

/// Where `a` meets `b` first in the last `time` seconds, that is, is in it by more than `depth` (m); nothing if it is
/// so when these begin or does not come so far in them. Looks as far ahead as nothing can happen (conservative
/// advancement: B. Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, Berkeley 1996, 2.3), but never less
/// far than all points go `step` (m) at most.
std::optional<TurnedMeeting> FindTurnedMeeting(const TurningGeometry& a, const TurningGeometry& b, double time,
                                               double step, double depth);

/// Where the point of `a` that is `depth` (m) in `b` as they meet came to the surface there, if that was in the last
/// `time` seconds; else `meeting`.
TurnedMeeting SurfacedBefore(const TurningGeometry& a, const TurningGeometry& b, const TurnedMeeting& meeting,
                             double depth, double time);

/// By how much (m) they overlap `time` seconds before the end; negative: they do not.
double DepthBefore(const TurningGeometry& a, const TurningGeometry& b, double time);

}  // namespace genphys

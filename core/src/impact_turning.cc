#include "impact_turning.h"

#include <algorithm>
#include <limits>

#include "genphys/placement.h"
#include "genphys/proximity.h"

namespace genphys {
namespace {

// So many are too few only for what turns by hundreds of radians in a step.
constexpr int kLooksMax = 400;
// Of the time between two looks: so near is the time at which they meet.
constexpr double kNarrow = 1.0 / 64;
// Speeds change on the way.
constexpr double kFaster = 1.2;

Placement PlacedBefore(const TurningGeometry& it, double time) {
  return ToPlacement(it.motion.PoseBefore(time).Transform(it.geometry.pose_in_entity));
}

Vector3 WayOf(const ImpactMotion& motion, double time) { return motion.CenterBefore(0) - motion.CenterBefore(time); }

class Approach {
 public:
  Approach(const TurningGeometry& a, const TurningGeometry& b, double time, double depth)
      : a_(a), b_(b), depth_(depth), velocity_((WayOf(a.motion, time) - WayOf(b.motion, time)) / time) {}

  // No two points of them approach faster, m/s.
  double SpeedMax() const {
    return kFaster * (velocity_.norm() + a_.motion.angular_velocity().norm() * a_.reach +
                      b_.motion.angular_velocity().norm() * b_.reach);
  }
  // The same towards a plane between them: what turns in that plane comes no nearer.
  double SpeedAlong(const Vector3& normal) const {
    return kFaster * (velocity_.dot(normal) + normal.cross(a_.motion.angular_velocity()).norm() * a_.reach +
                      normal.cross(b_.motion.angular_velocity()).norm() * b_.reach);
  }
  // Its distance is that to where they meet.
  std::optional<Proximity> Look(double time, double within) const {
    std::optional<Proximity> there = FindProximity(a_.geometry.shape, PlacedBefore(a_, time), b_.geometry.shape,
                                                   PlacedBefore(b_, time), within - depth_);
    if (there) there->distance += depth_;
    return there;
  }

  // They are apart `before` the end, as `seen`, and overlap at `after`, which is later.
  TurnedMeeting Narrow(double before, Proximity seen, double after) const {
    const double narrow = kNarrow * (before - after);
    while (before - after > narrow) {
      const double middle = (before + after) / 2;
      const std::optional<Proximity> there = Look(middle, std::numeric_limits<double>::infinity());
      if (there && there->distance > 0) {
        before = middle;
        seen = *there;
      } else {
        after = middle;
      }
    }
    return {before, -seen.normal, seen.on_b};
  }

 private:
  const TurningGeometry& a_;
  const TurningGeometry& b_;
  double depth_;      // m, in which they meet
  Vector3 velocity_;  // m/s, of a towards b
};

}  // namespace

std::optional<TurnedMeeting> FindTurnedMeeting(const TurningGeometry& a, const TurningGeometry& b, double time,
                                               double step, double depth) {
  const Approach approach(a, b, time, depth);
  const double fastest = approach.SpeedMax();
  double now = time, before = time;
  Proximity seen;
  for (int look = 0; look < kLooksMax; ++look) {
    const std::optional<Proximity> there = approach.Look(now, fastest * now);
    if (!there) return std::nullopt;
    if (!(there->distance > 0)) {
      if (look == 0) return std::nullopt;
      return approach.Narrow(before, seen, now);
    }
    const double speed = approach.SpeedAlong(there->normal);
    if (!(speed * now > there->distance)) return std::nullopt;
    before = now;
    seen = *there;
    now = std::max(now - std::max(there->distance / speed, step / fastest), 0.0);
  }
  return std::nullopt;
}

double DepthBefore(const TurningGeometry& a, const TurningGeometry& b, double time) {
  const std::optional<Proximity> there =
      FindProximity(a.geometry.shape, PlacedBefore(a, time), b.geometry.shape, PlacedBefore(b, time));
  return there ? -there->distance : -std::numeric_limits<double>::infinity();
}

}  // namespace genphys

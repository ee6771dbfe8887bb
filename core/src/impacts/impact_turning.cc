#include "impacts/impact_turning.h"

#include <algorithm>
#include <limits>

#include "genphys/placement.h"
#include "genphys/proximity.h"

namespace genphys {
namespace {

// So many are too few only for what turns by hundreds of radians in a step.
constexpr int kLooksMax = 400;
// By so many it is seen whether they would have to be so many more that the few there are would be in vain.
constexpr int kEarlyLooks = 16;
constexpr double kTooMany = 16 * kLooksMax;
// Of the time between two looks: so near is the time at which they meet.
constexpr double kNarrow = 1.0 / 64;
// Halvings of the time in which a point came to the surface.
constexpr int kSurfaceLooks = 12;
// Speeds change on the way.
constexpr double kFaster = 1.2;

Placement PlacedBefore(const ImpactMotion& motion, const Geometry& geometry, double time) {
  return ToPlacement(motion.PoseBefore(time).Transform(geometry.pose_in_entity));
}

Vector3 WayOf(const ImpactMotion& motion, double time) { return motion.CenterBefore(0) - motion.CenterBefore(time); }

// Whether that would take too many looks which came only so far (part of the way) by `looks`: the fewer these are, the
// farther off it must be.
bool IsInVain(int looks, double part) {
  const double unsure = static_cast<double>(kEarlyLooks) / looks;
  return looks <= kEarlyLooks && part * kTooMany * unsure * unsure < looks;
}

class Approach {
 public:
  Approach(const TurningGeometry& a, const TurningGeometry& b, double time, double depth)
      : a_(a),
        b_(b),
        motion_a_(a.motion),
        motion_b_(b.motion),
        depth_(depth),
        velocity_((WayOf(a.motion, time) - WayOf(b.motion, time)) / time) {}

  // Looks come one after the other, and a body is followed from each to the next.
  void GoFrom(double time) {
    motion_a_.GoFrom(time);
    motion_b_.GoFrom(time);
  }

  // No two points of them approach faster, m/s.
  double SpeedMax() const {
    return kFaster * (velocity_.norm() + motion_a_.angular_velocity().norm() * a_.reach +
                      motion_b_.angular_velocity().norm() * b_.reach);
  }
  // The same towards a plane between them: what turns in that plane comes no nearer.
  double SpeedAlong(const Vector3& normal) const {
    return kFaster * (velocity_.dot(normal) + normal.cross(motion_a_.angular_velocity()).norm() * a_.reach +
                      normal.cross(motion_b_.angular_velocity()).norm() * b_.reach);
  }
  // Its distance is that to where they meet.
  std::optional<Proximity> Look(double time, double within) const {
    std::optional<Proximity> there =
        FindProximity(a_.geometry.shape, PlacedBefore(motion_a_, a_.geometry, time), b_.geometry.shape,
                      PlacedBefore(motion_b_, b_.geometry, time), within - depth_);
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
  ImpactMotion motion_a_;
  ImpactMotion motion_b_;
  double depth_;      // m, in which they meet
  Vector3 velocity_;  // m/s, of a towards b
};

}  // namespace

std::optional<TurnedMeeting> FindTurnedMeeting(const TurningGeometry& a, const TurningGeometry& b, double time,
                                               double step, double depth) {
  Approach approach(a, b, time, depth);
  const double fastest = approach.SpeedMax();
  double now = time, before = time;
  Proximity seen;
  for (int look = 0; look < kLooksMax; ++look) {
    approach.GoFrom(now);
    const std::optional<Proximity> there = approach.Look(now, fastest * now);
    if (!there) return std::nullopt;
    if (!(there->distance > 0)) {
      if (look == 0) return std::nullopt;
      approach.GoFrom(before);
      return approach.Narrow(before, seen, now);
    }
    const double speed = approach.SpeedAlong(there->normal);
    if (!(speed * now > there->distance)) return std::nullopt;
    before = now;
    seen = *there;
    now = std::max(now - std::max(there->distance / speed, step / fastest), 0.0);
    if (IsInVain(look + 1, (time - now) / time)) return std::nullopt;
  }
  return std::nullopt;
}

TurnedMeeting SurfacedBefore(const TurningGeometry& a, const TurningGeometry& b, const TurnedMeeting& meeting,
                             double depth, double time) {
  const Placement place_a = ToPlacement(a.motion.PoseBefore(meeting.time));
  const Placement place_b = ToPlacement(b.motion.PoseBefore(meeting.time));
  const Vector3 on_a = place_a.ToLocal(meeting.position - depth * meeting.normal);
  const Vector3 on_b = place_b.ToLocal(meeting.position), normal = place_b.rotation.transpose() * meeting.normal;
  const auto height = [&](double before) {
    const Pose there = b.motion.PoseBefore(before);
    return (a.motion.PoseBefore(before).Transform(on_a) - there.Transform(on_b)).dot(there.orientation * normal);
  };
  double below = meeting.time, above = time;
  if (!(height(above) > 0)) return meeting;
  for (int look = 0; look < kSurfaceLooks; ++look) {
    const double middle = (below + above) / 2;
    (height(middle) > 0 ? above : below) = middle;
  }
  const Pose there = b.motion.PoseBefore(above);
  return {above, there.orientation * normal, there.Transform(on_b)};
}

double DepthBefore(const TurningGeometry& a, const TurningGeometry& b, double time) {
  const std::optional<Proximity> there = FindProximity(a.geometry.shape, PlacedBefore(a.motion, a.geometry, time),
                                                       b.geometry.shape, PlacedBefore(b.motion, b.geometry, time));
  return there ? -there->distance : -std::numeric_limits<double>::infinity();
}

}  // namespace genphys

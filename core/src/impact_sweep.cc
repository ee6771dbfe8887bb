#include "impact_sweep.h"

#include <algorithm>

#include "genphys/bounds.h"
#include "genphys/proximity.h"

namespace genphys {
namespace {

// Of its smallest half extent: who went less far in a step cannot have passed through anything unseen.
constexpr double kUnseenWay = 0.8;

class Sweeper {
 public:
  Sweeper(const ImpactWorld& world, const NearPairs& near, double step_size)
      : world_(world), near_(near), speed_(world, step_size) {}

  void Sweep(const FlownWay& way, std::vector<SweptPair>& swept) {
    const uint32_t row = Index(way.row);
    const auto& body = world_.scene.entities[row]->desc->rigid_body;
    if (!body || body->motion_type != MotionType::kDynamic) return;
    const Pose end = world_.state.pose(way.row);
    for (size_t i = 0; i < body->geometries.size(); ++i) {
      const Geometry& geometry = body->geometries[i];
      if (!IsConvex(geometry.shape)) continue;
      const Vector3& place = geometry.pose_in_entity.position;
      const Vector3 translation = end.Transform(place) - way.start.Transform(place);
      if (translation.norm() <= kUnseenWay * SmallestHalfExtent(geometry.shape)) continue;
      const Placement start = ToPlacement(way.start.Transform(geometry.pose_in_entity));
      SweepGeometry(way, world_.geometry_rows[row][i], geometry, start, translation, swept);
    }
  }

 private:
  void SweepGeometry(const FlownWay& way, GeometryRow own, const Geometry& geometry, const Placement& start,
                     const Vector3& translation, std::vector<SweptPair>& swept) {
    const Bounds bounds = BoundsOf(geometry.shape, start);
    found_.clear();
    const Bounds swept_bounds = bounds.Union({bounds.min + translation, bounds.max + translation});
    near_.VisitOthers(world_.rule, own, swept_bounds, [&](GeometryRow other) {
      if (world_.rule.Decide(own, other) == PairRule::Verdict::kCollide) found_.push_back(other);
    });
    std::sort(found_.begin(), found_.end(), [&](GeometryRow a, GeometryRow b) { return world_.rule.Before(a, b); });
    for (const GeometryRow other : found_) Meet(way, own, geometry, start, translation, other, swept);
  }

  void Meet(const FlownWay& way, GeometryRow own, const Geometry& geometry, const Placement& start,
            const Vector3& translation, GeometryRow other, std::vector<SweptPair>& swept) const {
    const EntityRow target = world_.rule.info(other).entity;
    const auto& rows = world_.geometry_rows[Index(target)];
    const auto place = static_cast<size_t>(std::find(rows.begin(), rows.end(), other) - rows.begin());
    const Geometry& there = world_.scene.entities[Index(target)]->desc->rigid_body->geometries[place];
    const Pose now = world_.state.pose(target);
    const Pose before{now.position - way.time * VelocityOf(target), now.orientation};
    const std::optional<ShapeHit> hit =
        SweepShape(geometry.shape, start, translation - (now.position - before.position), there.shape,
                   ToPlacement(before.Transform(there.pose_in_entity)));
    if (!hit || !(hit->fraction > 0)) return;
    SweptPair pair{way.row, target, own, other, (1 - hit->fraction) * way.time, 0};
    const Vector3 relative = (translation - (now.position - before.position)) / way.time;
    pair.closing = -relative.dot(hit->normal);
    if (!(pair.closing > speed_.Of(way.row, target, hit->normal))) return;
    if (!world_.rule.Before(own, other)) {
      std::swap(pair.entity_a, pair.entity_b);
      std::swap(pair.geometry_a, pair.geometry_b);
    }
    swept.push_back(pair);
  }

  // By which it came to where it is.
  Vector3 VelocityOf(EntityRow row) const {
    if (!world_.active[Index(row)]) return Vector3::Zero();
    const HalfStep& half = world_.layer.half_steps[Index(row)];
    return half.restarts ? Vector3(world_.state.linear_velocities.col(Index(row))) : half.velocity;
  }

  const ImpactWorld& world_;
  const NearPairs& near_;
  ImpactSpeed speed_;
  std::vector<GeometryRow> found_;
};

}  // namespace

std::vector<SweptPair> FindSwept(const ImpactWorld& world, const NearPairs& near, std::span<const FlownWay> ways,
                                 double step_size) {
  Sweeper sweeper(world, near, step_size);
  std::vector<SweptPair> swept;
  for (const FlownWay& way : ways) sweeper.Sweep(way, swept);
  return swept;
}

}  // namespace genphys

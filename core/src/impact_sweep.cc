#include "impact_sweep.h"

#include <algorithm>
#include <utility>

#include "genphys/bounds.h"
#include "genphys/proximity.h"

namespace genphys {
namespace {

// Of its smallest half extent: who went less far in a step cannot have passed through anything unseen.
constexpr double kUnseenWay = 0.8;
// So many near pairs are looked through in the time of one search.
constexpr size_t kPairsPerSearch = 32;

class Sweeper {
 public:
  Sweeper(const ImpactWorld& world, const NearPairs& near, double step_size, size_t expected)
      : world_(world), near_(near), speed_(world, step_size) {
    sweeps_.reserve(expected);
  }

  void Add(const FlownWay& way) {
    const uint32_t row = Index(way.row);
    const auto& body = world_.scene.entities[row]->desc->rigid_body;
    if (!body || body->motion_type == MotionType::kStatic) return;
    const Pose end = world_.state.pose(way.row);
    for (size_t i = 0; i < body->geometries.size(); ++i) {
      const Geometry& geometry = body->geometries[i];
      if (!IsConvex(geometry.shape)) continue;
      const Vector3& place = geometry.pose_in_entity.position;
      const Vector3 translation = place.isZero(0) ? Vector3(end.position - way.start.position)
                                                  : Vector3(end.Transform(place) - way.start.Transform(place));
      if (IsSeen(geometry.shape, translation)) continue;
      const Placement start = PlacedIn(ToPlacement(way.start), geometry.pose_in_entity);
      const Bounds bounds = BoundsOf(geometry.shape, start);
      sweeps_.push_back({&way, world_.geometry_rows[row][i], &geometry, start, translation,
                         bounds.Union({bounds.min + translation, bounds.max + translation})});
    }
  }

  Swept Find() {
    FindCandidates();
    std::sort(candidates_.begin(), candidates_.end(), [&](const Candidate& a, const Candidate& b) {
      return a.sweep != b.sweep ? a.sweep < b.sweep : world_.rule.Before(a.other, b.other);
    });
    Swept swept;
    for (const Candidate& candidate : candidates_) Meet(candidate, swept);
    return swept;
  }

 private:
  // A geometry on its way.
  struct Sweep {
    const FlownWay* way;
    GeometryRow own;
    const Geometry* geometry;
    Placement start;
    Vector3 translation;
    Bounds bounds;  // of all of the way
  };
  struct Candidate {
    uint32_t sweep;
    GeometryRow other;
    bool is_sensor;  // one of the two is
  };

  // Whether going so far takes it through nothing that the test at the end would not show.
  static bool IsSeen(const Shape& shape, const Vector3& way) {
    return way.norm() <= kUnseenWay * SmallestHalfExtent(shape);
  }

  // Where many are fast at once, as the links of chains are, one walk over all near pairs is less than a search for
  // each of them.
  void FindCandidates() {
    const bool walks = sweeps_.size() * kPairsPerSearch >= near_.pairs().size();
    for (uint32_t i = 0; i < sweeps_.size(); ++i) {
      const Sweep& sweep = sweeps_[i];
      if (walks && near_.KnowsAllIn(sweep.own, sweep.bounds)) {
        // Those of one entity follow each other.
        int& first = world_.swept_index[world_.rule.info(sweep.own).entity];
        if (first < 0) first = static_cast<int>(i);
        is_known_ = true;
      } else {
        near_.VisitOthers(world_.rule, sweep.own, sweep.bounds, [&](GeometryRow other) {
          const PairRule::Verdict verdict = world_.rule.Decide(sweep.own, other);
          if (verdict == PairRule::Verdict::kIgnore) return;
          candidates_.push_back({i, other, verdict == PairRule::Verdict::kSensor});
        });
      }
    }
    if (!is_known_) return;
    for (const NearPairs::Pair& pair : near_.pairs()) {
      AddKnown(pair.entity_a, pair.a, pair.b, pair.is_sensor);
      AddKnown(pair.entity_b, pair.b, pair.a, pair.is_sensor);
    }
    world_.swept_index.Clear();
  }

  void AddKnown(EntityRow entity, GeometryRow own, GeometryRow other, bool is_sensor) {
    const int first = std::as_const(world_.swept_index)[entity];
    if (first < 0) return;
    for (auto i = static_cast<uint32_t>(first); i < sweeps_.size() && sweeps_[i].way->row == entity; ++i) {
      const Sweep& sweep = sweeps_[i];
      if (sweep.own != own || !near_.KnowsAllIn(own, sweep.bounds)) continue;
      if (near_.MayReach(other, sweep.bounds)) candidates_.push_back({i, other, is_sensor});
    }
  }

  void Meet(const Candidate& candidate, Swept& swept) const {
    const Sweep& sweep = sweeps_[candidate.sweep];
    const GeometryRow other = candidate.other;
    const FlownWay& way = *sweep.way;
    const EntityRow target = world_.rule.info(other).entity;
    if (world_.flies[target] || (candidate.is_sensor && !world_.scene.world.recorded_events.sensors)) return;
    const auto& rows = world_.geometry_rows[Index(target)];
    const auto place = static_cast<size_t>(std::find(rows.begin(), rows.end(), other) - rows.begin());
    const Geometry& there = world_.scene.entities[Index(target)]->desc->rigid_body->geometries[place];
    // Since the target was hit it goes as it does now.
    const double time = std::min(way.time, std::as_const(world_.free_since)[target]);
    const Vector3 translation = time / way.time * sweep.translation;
    const Placement start{sweep.start.position + (sweep.translation - translation), sweep.start.rotation};
    const Pose now = world_.state.pose(target);
    const Pose before{now.position - time * VelocityOf(target), now.orientation};
    const Vector3 relative = translation - (now.position - before.position);
    // What goes the same way, like the next links of a chain, is not passed.
    if (IsSeen(sweep.geometry->shape, relative)) return;
    const Placement target_start = PlacedIn(ToPlacement(before), there.pose_in_entity);
    const Shape& shape = sweep.geometry->shape;
    if (StaysClear(shape, start, relative, there.shape, target_start)) return;
    const std::optional<ShapeHit> hit = SweepShape(shape, start, relative, there.shape, target_start);
    if (!hit || !(hit->fraction > 0)) return;
    SweptPair pair{way.row, target, sweep.own, other, (1 - hit->fraction) * time, 0};
    pair.closing = -relative.dot(hit->normal) / time;
    if (!candidate.is_sensor && !(pair.closing > speed_.Of(way.row, target, hit->normal))) return;
    if (!world_.rule.Before(sweep.own, other)) {
      std::swap(pair.entity_a, pair.entity_b);
      std::swap(pair.geometry_a, pair.geometry_b);
    }
    (candidate.is_sensor ? swept.visits : swept.hits).push_back(pair);
  }

  // Whether even the spheres around both are apart all the way.
  static bool StaysClear(const Shape& shape, const Placement& start, const Vector3& relative, const Shape& other,
                         const Placement& place) {
    const Vector3 between = place.position - start.position;
    const double nearest = std::clamp(between.dot(relative) / relative.squaredNorm(), 0.0, 1.0);
    const double reach = BoundingRadius(shape) + BoundingRadius(other);
    return (between - nearest * relative).squaredNorm() > reach * reach;
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
  std::vector<Sweep> sweeps_;
  std::vector<Candidate> candidates_;
  bool is_known_ = false;  // some candidates are among the near pairs
};

}  // namespace

Swept FindSwept(const ImpactWorld& world, const NearPairs& near, std::span<const FlownWay> ways, double step_size) {
  Sweeper sweeper(world, near, step_size, ways.size());
  for (const FlownWay& way : ways) sweeper.Add(way);
  return sweeper.Find();
}

}  // namespace genphys

#include "impacts/impact_sweep.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "genphys/bounds.h"
#include "genphys/narrow_phase.h"
#include "genphys/proximity.h"
#include "impacts/impact_motion.h"
#include "impacts/impact_turning.h"

namespace genphys {
namespace {

// Of its smallest half extent: who went less far in a step cannot have passed through anything unseen.
constexpr double kUnseenWay = 0.8;
// The same of who touches something and turns about where it does.
constexpr double kUnseenTurn = 1.5;
// About its local z.
bool IsRound(const Shape& shape) {
  return std::holds_alternative<Capsule>(shape) || std::holds_alternative<Cylinder>(shape) ||
         std::holds_alternative<Cone>(shape);
}

// How far a geometry within `radius` goes at most by turning about its middle, m; `turn` is that of its body, in the
// world.
double TurnedWay(const Geometry& geometry, double radius, const Pose& pose, const Vector3& turn) {
  if (!IsRound(geometry.shape)) return radius * turn.norm();
  const Vector3 axis = pose.orientation * (geometry.pose_in_entity.orientation * Vector3::UnitZ());
  return radius * axis.cross(turn).norm();
}

// How far an arc leaves its chord, m.
double Bend(double arm, double angle) { return arm * angle * angle / 8; }

// Of the way that is seen: so deep what is in touch already may roll into the other one, and so much deeper than it is.
constexpr double kRolledIn = 0.25;
constexpr double kRolledOn = 0.05;
// Of a substep: nearer to when they were hit last what comes to the surface of the other one is the place of that.
constexpr double kLeastTime = 1.0 / 16;
// So many near pairs are looked through in the time of one search.
constexpr size_t kPairsPerSearch = 32;

class Sweeper {
 public:
  Sweeper(const ImpactWorld& world, const NearPairs& near, double step_size, size_t expected)
      : world_(world), near_(near), speed_(world, step_size), step_size_(step_size) {
    sweeps_.reserve(expected);
  }

  void Add(const FlownWay& way) {
    const uint32_t row = Index(way.row);
    const auto& body = world_.scene.entities[row]->desc->rigid_body;
    if (!body || body->motion_type == MotionType::kStatic) return;
    // All that others do to it happens where it is.
    if (world_.shoved[way.row]) return;
    const Pose end = world_.state.pose(way.row);
    const Vector3 turn = way.time * world_.state.angular_velocities.col(row);
    const double angle = turn.norm();
    const auto first = static_cast<int>(sweeps_.size());
    for (size_t i = 0; i < body->geometries.size(); ++i) {
      const Geometry& geometry = body->geometries[i];
      const Shape& shape = geometry.shape;
      if (!IsConvex(shape)) continue;
      const Vector3& place = geometry.pose_in_entity.position;
      const Vector3 translation = place.isZero(0) ? Vector3(end.position - way.start.position)
                                                  : Vector3(end.Transform(place) - way.start.Transform(place));
      const double unseen = kUnseenWay * SmallestHalfExtent(shape), radius = BoundingRadius(shape);
      const double arm = (place - CenterOf(way.row)).norm(), bend = Bend(arm, angle);
      const bool is_sphere = std::holds_alternative<Sphere>(shape);
      const bool turns = bend + (is_sphere ? 0 : radius * angle) > unseen &&
                         bend + (is_sphere ? 0 : TurnedWay(geometry, radius, end, turn)) > unseen;
      if (!turns && translation.norm() <= unseen) continue;
      const Placement start = PlacedIn(ToPlacement(way.start), geometry.pose_in_entity);
      Sweep& sweep = sweeps_.emplace_back(Sweep{.way = &way,
                                                .own = world_.geometry_rows[row][i],
                                                .geometry = &geometry,
                                                .start = start,
                                                .translation = translation,
                                                .bounds = {},
                                                .unseen = unseen});
      if (turns) {
        sweep.reach = arm + radius;
        sweep.bend = bend;
      }
      const Vector3 around = Vector3::Constant(radius + bend);
      const Bounds bounds = turns ? Bounds{start.position - around, start.position + around} : BoundsOf(shape, start);
      sweep.bounds = bounds.Union({bounds.min + translation, bounds.max + translation});
    }
    if (sweeps_.size() > static_cast<size_t>(first)) world_.swept_index[way.row] = first;
  }

  Swept Find() {
    FindCandidates();
    FindCrossing();
    Order();
    Swept swept;
    for (const Candidate& candidate : candidates_) Meet(candidate, swept);
    std::ranges::sort(swept.flyers);
    swept.flyers.erase(std::unique(swept.flyers.begin(), swept.flyers.end()), swept.flyers.end());
    world_.swept_index.Clear();
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
    Bounds bounds;          // of all of the way
    double unseen;          // m, that it may go and pass through nothing that the test at the end would not show
    double reach = 0;       // m, from where its body turns about to all of it; zero: it hardly turns
    double bend = 0;        // m, by which its middle leaves the straight way
    bool is_known = false;  // all that it may meet is in the near pairs
  };
  struct Hit {
    double time;     // s before the end
    double closing;  // m/s
    Vector3 normal;  // out of what is hit
    bool is_deep = false;
  };
  // How it may meet another one in the time that is left.
  struct Encounter {
    double time;       // s before the end, from when on both go as they do now
    Vector3 start;     // where its middle is then
    Vector3 target;    // where that of the other one is
    Vector3 relative;  // m, its way past the other one
    double bend;       // m, by which the middle of the other one leaves the straight way
  };
  // Of what turns.
  struct Passage {
    Placement end;
    Bounds bounds;  // of all of its way, in its frame as it is at the end
  };
  struct Candidate {
    uint32_t sweep;
    GeometryRow other;
    bool is_sensor;  // one of the two is
  };

  bool IsMoved(EntityRow row) const {
    return world_.active[Index(row)] &&
           world_.scene.entities[Index(row)]->desc->rigid_body->motion_type == MotionType::kDynamic;
  }

  // About which it turns, in its frame.
  Vector3 CenterOf(EntityRow row) const {
    return IsMoved(row) ? world_.scene.entities[Index(row)]->mass.center_of_mass : Vector3(Vector3::Zero());
  }

  // From there to all of a geometry, m.
  double ReachOf(EntityRow row, const Geometry& geometry) const {
    return (geometry.pose_in_entity.position - CenterOf(row)).norm() + BoundingRadius(geometry.shape);
  }

  ImpactMotion MotionOf(const FlownWay& way) const {
    const uint32_t row = Index(way.row);
    const Vector3 linear = world_.state.linear_velocities.col(row), angular = world_.state.angular_velocities.col(row);
    const Pose end = world_.state.pose(way.row);
    if (!IsMoved(way.row)) return ImpactMotion::Driven(end, linear, angular);
    const MassProperties& mass = world_.scene.entities[row]->mass;
    if (world_.jointed[way.row]) {
      return ImpactMotion::Along(way.start, way.time, end, mass, linear, angular, way.acceleration, way.torque);
    }
    const bool flies = speed_.IsInFlight(way.row) && way.time == step_size_;
    return ImpactMotion::Free(end, mass, linear, angular, flies ? world_.accelerations[way.row] : way.acceleration);
  }

  Vector3 SpinOf(EntityRow row) const {
    if (!world_.active[Index(row)] || world_.shoved[row]) return Vector3::Zero();
    return world_.state.angular_velocities.col(Index(row));
  }

  // Of one that is met.
  ImpactMotion StraightMotionOf(EntityRow target) const {
    const uint32_t row = Index(target);
    const Pose now = world_.state.pose(target);
    const Vector3 linear = VelocityOf(target);
    const Vector3 spin = SpinOf(target);
    if (!IsMoved(target)) return ImpactMotion::Driven(now, linear, spin);
    return ImpactMotion::Free(now, world_.scene.entities[row]->mass, linear, spin, Vector3::Zero());
  }

  // The same for one that goes its way, as long as another one is not asked for.
  const ImpactMotion& MotionOn(const FlownWay& way) {
    if (!motion_ || motion_of_ != &way) motion_ = MotionOf(way);
    motion_of_ = &way;
    return *motion_;
  }

  // Where many are fast at once, as the links of chains are, one walk over all near pairs is less than a search for
  // each of them.
  void FindCandidates() {
    const bool walks = sweeps_.size() * kPairsPerSearch >= near_.pairs().size();
    bool is_known = false;
    for (uint32_t i = 0; i < sweeps_.size(); ++i) {
      Sweep& sweep = sweeps_[i];
      sweep.is_known = walks && near_.KnowsAllIn(sweep.own, sweep.bounds);
      if (sweep.is_known) {
        is_known = true;
      } else {
        searched_.push_back(i);
        if (sweep.reach > 0) KeepToPassage(sweep);
        near_.VisitOthers(world_.rule, sweep.own, sweep.bounds, [&](GeometryRow other) {
          const PairRule::Verdict verdict = world_.rule.Decide(sweep.own, other);
          if (verdict == PairRule::Verdict::kIgnore) return;
          candidates_.push_back({i, other, verdict == PairRule::Verdict::kSensor});
        });
      }
    }
    if (!is_known) return;
    for (const NearPairs::Pair& pair : near_.pairs()) AddKnown(pair);
  }

  // What is long and turns comes near to far fewer than are as near to its middle as its ends.
  void KeepToPassage(Sweep& sweep) {
    const Passage& passage = PassageOf(sweep);
    if (!passage.bounds.min.allFinite()) return;
    const Vector3 middle = passage.end.Transform((passage.bounds.min + passage.bounds.max) / 2);
    const Vector3 extent = passage.end.rotation.cwiseAbs() * ((passage.bounds.max - passage.bounds.min) / 2);
    const Bounds passed{middle - extent, middle + extent};
    if (!passed.Overlaps(sweep.bounds)) return;
    sweep.bounds = {sweep.bounds.min.cwiseMax(passed.min), sweep.bounds.max.cwiseMin(passed.max)};
  }

  // Two whose ways cross may both be past the other one by now. One that stays in its neighbourhood is found there.
  void FindCrossing() {
    if (searched_.size() < 2) return;
    Bounds all = sweeps_[searched_.front()].bounds;
    for (const uint32_t i : searched_) all = all.Union(sweeps_[i].bounds);
    Eigen::Index axis = 0;
    (all.max - all.min).maxCoeff(&axis);
    std::vector<uint32_t>& order = searched_;
    std::ranges::sort(order, {}, [&](uint32_t i) { return std::pair(sweeps_[i].bounds.min[axis], i); });
    for (size_t i = 0; i < order.size(); ++i) {
      const Sweep& sweep = sweeps_[order[i]];
      for (size_t j = i + 1; j < order.size(); ++j) {
        const Sweep& other = sweeps_[order[j]];
        if (other.bounds.min[axis] > sweep.bounds.max[axis]) break;
        if (sweep.way == other.way || !sweep.bounds.Overlaps(other.bounds)) continue;
        const PairRule::Verdict verdict = world_.rule.Decide(sweep.own, other.own);
        if (verdict == PairRule::Verdict::kIgnore) continue;
        candidates_.push_back({order[i], other.own, verdict == PairRule::Verdict::kSensor});
      }
    }
  }

  // Of two that are both on their ways only one is taken along its own, always the same, however they were found.
  void Order() {
    for (Candidate& candidate : candidates_) {
      const std::optional<uint32_t> other = SweepOf(world_.rule.info(candidate.other).entity, candidate.other);
      if (!other || !GoesFirst(*other, candidate.sweep)) continue;
      candidate = {*other, sweeps_[candidate.sweep].own, candidate.is_sensor};
    }
    std::ranges::sort(candidates_, [&](const Candidate& a, const Candidate& b) {
      return a.sweep != b.sweep ? a.sweep < b.sweep : world_.rule.Before(a.other, b.other);
    });
    const auto is_same = [](const Candidate& a, const Candidate& b) {
      return a.sweep == b.sweep && a.other == b.other;
    };
    candidates_.erase(std::unique(candidates_.begin(), candidates_.end(), is_same), candidates_.end());
  }

  // What turns, or is thinner.
  bool GoesFirst(uint32_t a, uint32_t b) const {
    const auto key = [&](uint32_t i) { return std::tuple(!(sweeps_[i].reach > 0), sweeps_[i].unseen, i); };
    return key(a) < key(b);
  }

  void AddKnown(const NearPairs::Pair& pair) {
    const std::optional<uint32_t> a = SweepOf(pair.entity_a, pair.a), b = SweepOf(pair.entity_b, pair.b);
    const bool is_known_a = a && sweeps_[*a].is_known, is_known_b = b && sweeps_[*b].is_known;
    if (a && b) {
      if (!(is_known_a || is_known_b) || !sweeps_[*a].bounds.Overlaps(sweeps_[*b].bounds)) return;
      candidates_.push_back(GoesFirst(*a, *b) ? Candidate{*a, pair.b, pair.is_sensor}
                                              : Candidate{*b, pair.a, pair.is_sensor});
    } else if (is_known_a) {
      if (near_.MayReach(pair.b, sweeps_[*a].bounds)) candidates_.push_back({*a, pair.b, pair.is_sensor});
    } else if (is_known_b) {
      if (near_.MayReach(pair.a, sweeps_[*b].bounds)) candidates_.push_back({*b, pair.a, pair.is_sensor});
    }
  }

  std::optional<uint32_t> SweepOf(EntityRow entity, GeometryRow own) const {
    const int first = std::as_const(world_.swept_index)[entity];
    if (first < 0) return std::nullopt;
    // Those of one entity follow each other.
    for (auto i = static_cast<uint32_t>(first); i < sweeps_.size() && sweeps_[i].way->row == entity; ++i) {
      if (sweeps_[i].own == own) return i;
    }
    return std::nullopt;
  }

  void Meet(const Candidate& candidate, Swept& swept) {
    const Sweep& sweep = sweeps_[candidate.sweep];
    const GeometryRow other = candidate.other;
    const EntityRow target = world_.rule.info(other).entity;
    if (candidate.is_sensor && !world_.scene.world.recorded_events.sensors) return;
    if (world_.flies[target]) {
      // Where it is in its region is only known when it is taken out of it.
      if (near_.MayTouch(other, sweep.bounds)) swept.flyers.push_back(target);
      return;
    }
    const auto& rows = world_.geometry_rows[Index(target)];
    const auto place = static_cast<size_t>(std::find(rows.begin(), rows.end(), other) - rows.begin());
    const Geometry& there = world_.scene.entities[Index(target)]->desc->rigid_body->geometries[place];
    // Since the target was hit it goes as it does now.
    const double time = std::min(sweep.way->time, std::as_const(world_.free_since)[target]);
    const Encounter encounter = EncounterOf(sweep, target, there, time);
    if (StaysClear(sweep, encounter, there)) return;
    if (sweep.reach > 0 && TurnsClear(sweep, encounter, target, there)) return;
    const std::optional<Hit> hit =
        sweep.reach > 0 ? MeetTurning(sweep, encounter, target, there) : MeetStraight(sweep, encounter, target, there);
    if (!hit) return;
    SweptPair pair{sweep.way->row, target, sweep.own, other, hit->time, hit->closing, hit->is_deep};
    if (!candidate.is_sensor && !(pair.closing > speed_.Of(sweep.way->row, target, hit->normal))) return;
    if (!world_.rule.Before(sweep.own, other)) {
      std::swap(pair.entity_a, pair.entity_b);
      std::swap(pair.geometry_a, pair.geometry_b);
    }
    (candidate.is_sensor ? swept.visits : swept.hits).push_back(pair);
  }

  Encounter EncounterOf(const Sweep& sweep, EntityRow target, const Geometry& there, double time) const {
    const Vector3 translation = time / sweep.way->time * sweep.translation;
    const Vector3& place = there.pose_in_entity.position;
    const Pose now = world_.state.pose(target);
    const Vector3 way = time * VelocityOf(target);
    return {time, sweep.start.position + (sweep.translation - translation),
            (place.isZero(0) ? now.position : now.Transform(place)) - way, translation - way,
            Bend((place - CenterOf(target)).norm(), time * SpinOf(target).norm())};
  }

  static Placement StartOf(const Sweep& sweep, const Encounter& encounter) {
    return {encounter.start, sweep.start.rotation};
  }

  // Of the other one, as it stands now.
  Placement TargetOf(EntityRow target, const Geometry& there, const Encounter& encounter) const {
    const Placement now = PlacedIn(ToPlacement(world_.state.pose(target)), there.pose_in_entity);
    return {encounter.target, now.rotation};
  }

  // Whether even the spheres around both are apart all the way.
  static bool StaysClear(const Sweep& sweep, const Encounter& encounter, const Geometry& there) {
    const Vector3& relative = encounter.relative;
    const Vector3 between = encounter.target - encounter.start;
    const double square = relative.squaredNorm();
    const double nearest = square > 0 ? std::clamp(between.dot(relative) / square, 0.0, 1.0) : 0;
    const double reach =
        BoundingRadius(sweep.geometry->shape) + BoundingRadius(there.shape) + sweep.bend + encounter.bend;
    return (between - nearest * relative).squaredNorm() > reach * reach;
  }

  // Whether what turns is clear of the other one's bounds in its own frame, however slender the two are.
  bool TurnsClear(const Sweep& sweep, const Encounter& encounter, EntityRow target, const Geometry& there) {
    const Passage& passage = PassageOf(sweep);
    const auto is_clear = [&](const Bounds& others) { return !passage.bounds.Overlaps(others); };
    const auto bounds_at = [&](const Placement& place) { return BoundsOf(there.shape, passage.end.ToLocal(place)); };
    if (SpinOf(target).isZero(0)) {
      const Vector3 way = passage.end.rotation.transpose() * (encounter.time * VelocityOf(target));
      const Bounds before = bounds_at(TargetOf(target, there, encounter));
      return is_clear(before.Union(before.Shifted(way)));
    }
    const ImpactMotion others = StraightMotionOf(target);
    const Placement now = ToPlacement(others.pose()), before = ToPlacement(others.PoseBefore(encounter.time));
    const Bounds ends =
        bounds_at(PlacedIn(now, there.pose_in_entity)).Union(bounds_at(PlacedIn(before, there.pose_in_entity)));
    return is_clear(ends.Widened(others.BowMax(encounter.time, ReachOf(target, there))));
  }

  // Those of one sweep are looked at one after the other.
  const Passage& PassageOf(const Sweep& sweep) {
    if (passage_of_ == &sweep) return passage_;
    const ImpactMotion& motion = MotionOn(*sweep.way);
    const Shape& shape = sweep.geometry->shape;
    const Pose& place = sweep.geometry->pose_in_entity;
    passage_of_ = &sweep;
    passage_.end = PlacedIn(ToPlacement(motion.pose()), place);
    const Placement start = PlacedIn(ToPlacement(motion.PoseBefore(sweep.way->time)), place);
    const Bounds ends = BoundsOf(shape, {}).Union(BoundsOf(shape, passage_.end.ToLocal(start)));
    passage_.bounds = ends.Widened(motion.BowMax(sweep.way->time, sweep.reach));
    return passage_;
  }

  std::optional<Hit> MeetStraight(const Sweep& sweep, const Encounter& encounter, EntityRow target,
                                  const Geometry& there) const {
    const double time = encounter.time;
    const Vector3& relative = encounter.relative;
    const Shape& shape = sweep.geometry->shape;
    // What goes the same way, like the next links of a chain, is not passed.
    if (relative.norm() <= sweep.unseen) return std::nullopt;
    const Placement start = StartOf(sweep, encounter), place = TargetOf(target, there, encounter);
    std::optional<ShapeHit> hit = SweepShape(shape, start, relative, there.shape, place);
    if (hit && !(hit->fraction > 0) && !SpinOf(target).isZero(0)) {
      // Before it turned they may have been apart.
      const Placement before = ToPlacement(StraightMotionOf(target).PoseBefore(time));
      hit = SweepShape(shape, start, relative, there.shape, PlacedIn(before, there.pose_in_entity));
    }
    if (!hit) return std::nullopt;
    if (!(hit->fraction > 0)) return MeetTouching(sweep, encounter, target, there);
    return Hit{(1 - hit->fraction) * time, -relative.dot(hit->normal) / time, hit->normal};
  }

  // Whether two that touched when one of them was hit last go through each other from there, which no solve holds.
  std::optional<Hit> MeetTouching(const Sweep& sweep, const Encounter& encounter, EntityRow target,
                                  const Geometry& there) const {
    if (!(encounter.time < step_size_ || world_.shoved[target])) return std::nullopt;
    Manifold manifold;
    FindContacts(sweep.geometry->shape, StartOf(sweep, encounter), there.shape, TargetOf(target, there, encounter), 0,
                 manifold);
    std::optional<Hit> hit;
    double deepest = 0;
    for (const MeetingPoint& point : std::span(manifold.points).first(static_cast<size_t>(manifold.count))) {
      const double way = encounter.relative.dot(point.normal);
      if (point.depth < deepest || way <= sweep.unseen) continue;
      deepest = point.depth;
      hit = Hit{encounter.time, way / encounter.time, -point.normal};
    }
    return hit;
  }

  std::optional<Hit> MeetTurning(const Sweep& sweep, const Encounter& encounter, EntityRow target,
                                 const Geometry& there) {
    const ImpactMotion& own = MotionOn(*sweep.way);
    const ImpactMotion others = StraightMotionOf(target);
    // What goes and turns the same way is not passed.
    const Vector3 spin = others.angular_velocity();
    const Vector3 between = own.CenterBefore(0) - others.CenterBefore(0);
    const double slip = (own.linear_velocity() - others.linear_velocity() - spin.cross(between)).norm() +
                        (own.angular_velocity() - spin).norm() * sweep.reach;
    const double unseen = sweep.unseen;
    if (slip * encounter.time <= unseen) return std::nullopt;
    const TurningGeometry mine{own, *sweep.geometry, sweep.reach};
    const TurningGeometry theirs{others, there, IsConvex(there.shape) ? ReachOf(target, there) : 0};
    const auto meets = [&](double depth) -> std::optional<Hit> {
      std::optional<TurnedMeeting> meeting = FindTurnedMeeting(mine, theirs, encounter.time, unseen, depth);
      if (!meeting) return std::nullopt;
      // Another corner than the one that is in touch came down before it was so deep.
      if (depth > 0) {
        const TurnedMeeting surfaced = SurfacedBefore(mine, theirs, *meeting, depth, encounter.time);
        const bool is_since_blow = encounter.time < step_size_;
        const double earliest = encounter.time - (is_since_blow ? kLeastTime * step_size_ : 0);
        if (surfaced.time <= earliest) meeting = surfaced;
      }
      const Vector3 approach = own.BodyBefore(meeting->time).VelocityAt(meeting->position) -
                               others.BodyBefore(meeting->time).VelocityAt(meeting->position);
      return Hit{meeting->time, -approach.dot(meeting->normal), meeting->normal, depth > 0};
    };
    const std::optional<Hit> hit = meets(0);
    if (hit && hit->closing > speed_.Of(sweep.way->row, target, hit->normal)) return hit;
    // What is in touch and turns on may roll into the other one, or the far end of something slender falls on it.
    const double turn = (own.angular_velocity() - spin).norm() * encounter.time;
    const double depth = std::max(DepthBefore(mine, theirs, encounter.time), 0.0);
    const bool is_since_blow = depth > 0 && (encounter.time < step_size_ || world_.shoved[target]);
    if (!is_since_blow && turn < kRollingTurn &&
        turn * sweep.reach <= kUnseenTurn * SmallestHalfExtent(sweep.geometry->shape)) {
      return std::nullopt;
    }
    return meets(std::max(kRolledIn * unseen, depth + kRolledOn * unseen));
  }

  // By which it came to where it is; of whom others hit there none.
  Vector3 VelocityOf(EntityRow row) const {
    if (!world_.active[Index(row)] || world_.shoved[row]) return Vector3::Zero();
    const HalfStep& half = world_.layer.half_steps[Index(row)];
    return half.restarts ? Vector3(world_.state.linear_velocities.col(Index(row))) : half.velocity;
  }

  const ImpactWorld& world_;
  const NearPairs& near_;
  ImpactSpeed speed_;
  double step_size_;
  std::vector<Sweep> sweeps_;
  std::optional<ImpactMotion> motion_;
  const FlownWay* motion_of_ = nullptr;
  Passage passage_;
  const Sweep* passage_of_ = nullptr;
  std::vector<Candidate> candidates_;
  std::vector<uint32_t> searched_;  // that leave the neighbourhood of which all near pairs are known
};

}  // namespace

Swept FindSwept(const ImpactWorld& world, const NearPairs& near, std::span<const FlownWay> ways, double step_size) {
  Sweeper sweeper(world, near, step_size, ways.size());
  for (const FlownWay& way : ways) sweeper.Add(way);
  return sweeper.Find();
}

}  // namespace genphys

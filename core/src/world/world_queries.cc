#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "genphys/limits.h"
#include "genphys/narrow_phase.h"
#include "genphys/proximity.h"
#include "genphys/ray_cast.h"
#include "genphys/work_watch.h"
#include "genphys/world.h"
#include "model/cat.h"
#include "model/validate.h"
#include "pairs/contact_points.h"
#include "pairs/near_pairs.h"

namespace genphys {
namespace {

Status CheckRays(std::span<const Ray> rays) {
  for (size_t i = 0; i < rays.size(); ++i) {
    const auto path = [&](std::string_view column) { return Cat(column, "[", i, "]"); };
    GENPHYS_RETURN_IF_ERROR(CheckVector(rays[i].origin, Limits::kPositionMax, path("origins")));
    GENPHYS_RETURN_IF_ERROR(CheckVector(rays[i].translation, Limits::kRayLengthMax, path("translations")));
  }
  return absl::OkStatus();
}

Status CheckCount(size_t results, std::string_view field) {
  if (results <= Limits::kQueryResultsMax) return absl::OkStatus();
  return Refuse(Reason::kLimitExceeded, std::string(field),
                Cat("there are more than ", Limits::kQueryResultsMax, " results: ask in smaller parts"));
}

// Of a WorkWatch, which is asked after about a hundred rays, or ten shapes.
constexpr int64_t kRayWork = WorkWatch::kUsualSpell / 100;
constexpr int64_t kShapeWork = WorkWatch::kUsualSpell / 10;
// Of the same: for a geometry that one of them comes upon, and for somebody who touches whom is asked about.
constexpr int64_t kGeometryWork = 64;
constexpr int64_t kTouchWork = 256;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Placement PlacementOf(const Pose& pose) { return ToPlacement({pose.position, pose.orientation.normalized()}); }

}  // namespace

Status World::CheckQuery(Feature feature) const {
  if (near_ != nullptr && backend_->capabilities().Has(feature)) return absl::OkStatus();
  return UnsupportedFeature(feature, scene_.world.engine, "");
}

Status World::CheckShapeQuery(const Shape& shape, std::span<const Pose> poses) const {
  GENPHYS_RETURN_IF_ERROR(CheckQuery(Feature::kShapeQueries));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckShape(shape), "shape"));
  if (!IsConvex(shape)) return Refuse(Reason::kInvalidValue, "shape", "a query asks for a bounded convex shape");
  for (size_t i = 0; i < poses.size(); ++i) {
    GENPHYS_RETURN_IF_ERROR(CheckVector(poses[i].position, Limits::kPositionMax, Cat("positions[", i, "]")));
    GENPHYS_RETURN_IF_ERROR(CheckOrientation(poses[i].orientation, Cat("orientations[", i, "]")));
  }
  return absl::OkStatus();
}

// In order of ids, so that nothing depends on the engine's order.
std::vector<GeometryRow> World::RowsIn(const Bounds& bounds, uint64_t collides_with_bits) {
  std::vector<GeometryRow> rows;
  near_->VisitBounds(bounds, [&](GeometryRow row) {
    WorkWatch::Spend(kGeometryWork);
    if (rule_.SeenByRay(row, collides_with_bits)) rows.push_back(row);
  });
  std::sort(rows.begin(), rows.end(), [&](GeometryRow a, GeometryRow b) { return rule_.Before(a, b); });
  return rows;
}

std::pair<const Geometry*, Placement> World::Placed(GeometryRow row) const {
  const PairRule::GeometryInfo& info = rule_.info(row);
  const GeometryRows& rows = geometry_rows_[Index(info.entity)];
  const auto place = static_cast<size_t>(std::find(rows.begin(), rows.end(), row) - rows.begin());
  const Geometry& geometry = scene_.entities[Index(info.entity)]->desc->rigid_body->geometries[place];
  return {&geometry, ToPlacement(state_.pose(info.entity).Transform(geometry.pose_in_entity))};
}

Result<std::vector<RayHit>> World::CastRays(std::span<const Ray> rays, uint64_t collides_with_bits) {
  GENPHYS_RETURN_IF_ERROR(CheckQuery(Feature::kRayCasts));
  GENPHYS_RETURN_IF_ERROR(CheckRays(rays));
  std::vector<RayHit> hits(rays.size());
  for (size_t i = 0; i < rays.size(); ++i) {
    WorkWatch::Spend(kRayWork);
    hits[i] = CastRay(rays[i], collides_with_bits);
  }
  return hits;
}

RayHit World::CastRay(const Ray& ray, uint64_t collides_with_bits) const {
  RayHit best;
  best.fraction = 1;
  near_->VisitRay(ray, best.fraction, [&](GeometryRow row) {
    WorkWatch::Spend(kGeometryWork);
    if (!rule_.SeenByRay(row, collides_with_bits)) return;
    const auto [geometry, placement] = Placed(row);
    const auto hit =
        EnterShape(geometry->shape, {placement.ToLocal(ray.origin), placement.rotation.transpose() * ray.translation});
    if (!hit) return;
    const EntityId id = rule_.info(row).entity_id;
    // Of equally near ones the smaller id, whatever the order in which they are visited.
    const bool is_better = best.entity.is_null() || std::tie(hit->fraction, id) < std::tie(best.fraction, best.entity);
    if (is_better) best = {id, hit->fraction, placement.rotation * hit->normal};
  });
  return best.entity.is_null() ? RayHit{} : best;
}

Result<std::vector<std::vector<RayEntry>>> World::CastRaysThrough(std::span<const Ray> rays,
                                                                  uint64_t collides_with_bits) {
  GENPHYS_RETURN_IF_ERROR(CheckQuery(Feature::kShapeQueries));
  GENPHYS_RETURN_IF_ERROR(CheckRays(rays));
  std::vector<std::vector<RayEntry>> all(rays.size());
  const double whole = 1;
  size_t count = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    WorkWatch::Spend(kRayWork);
    near_->VisitRay(rays[i], whole, [&](GeometryRow row) {
      WorkWatch::Spend(kGeometryWork);
      if (!rule_.SeenByRay(row, collides_with_bits)) return;
      const auto [geometry, placement] = Placed(row);
      const Ray local{placement.ToLocal(rays[i].origin), placement.rotation.transpose() * rays[i].translation};
      const std::optional<SurfaceHit> hit = EnterShape(geometry->shape, local);
      if (!hit) return;
      all[i].push_back({{rule_.info(row).entity_id, geometry->id}, hit->fraction, placement.rotation * hit->normal});
    });
    std::sort(all[i].begin(), all[i].end(), [](const RayEntry& a, const RayEntry& b) {
      return std::tie(a.fraction, a.hit) < std::tie(b.fraction, b.hit);
    });
    count += all[i].size();
    GENPHYS_RETURN_IF_ERROR(CheckCount(count, "origins"));
  }
  return all;
}

Result<std::vector<ShapeCastHit>> World::CastShape(const Shape& shape, std::span<const Pose> poses,
                                                   std::span<const Vector3> translations, uint64_t collides_with_bits) {
  GENPHYS_RETURN_IF_ERROR(CheckShapeQuery(shape, poses));
  if (translations.size() != poses.size()) {
    return Refuse(Reason::kInvalidValue, "translations", "there must be as many translations as positions");
  }
  std::vector<ShapeCastHit> hits(poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    GENPHYS_RETURN_IF_ERROR(CheckVector(translations[i], Limits::kRayLengthMax, Cat("translations[", i, "]")));
    WorkWatch::Spend(kShapeWork);
    const Placement placement = PlacementOf(poses[i]);
    const Bounds start = BoundsOf(shape, placement);
    const Bounds end{start.min + translations[i], start.max + translations[i]};
    for (const GeometryRow row : RowsIn(start.Union(end), collides_with_bits)) {
      WorkWatch::Spend(kGeometryWork);
      const auto [geometry, there] = Placed(row);
      const std::optional<ShapeHit> hit = SweepShape(shape, placement, translations[i], geometry->shape, there);
      if (!hit || (!hits[i].hit.entity.is_null() && hit->fraction >= hits[i].fraction)) continue;
      hits[i] = {{rule_.info(row).entity_id, geometry->id}, hit->fraction, hit->position, hit->normal};
    }
  }
  return hits;
}

Result<std::vector<std::vector<GeometryId>>> World::FindOverlaps(const Shape& shape, std::span<const Pose> poses,
                                                                 uint64_t collides_with_bits) {
  GENPHYS_RETURN_IF_ERROR(CheckShapeQuery(shape, poses));
  std::vector<std::vector<GeometryId>> overlaps(poses.size());
  Manifold manifold;
  size_t count = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    WorkWatch::Spend(kShapeWork);
    const Placement placement = PlacementOf(poses[i]);
    for (const GeometryRow row : RowsIn(BoundsOf(shape, placement), collides_with_bits)) {
      const auto [geometry, there] = Placed(row);
      FindContacts(geometry->shape, there, shape, placement, 0, manifold);
      if (manifold.count > 0) overlaps[i].push_back({rule_.info(row).entity_id, geometry->id});
    }
    count += overlaps[i].size();
    GENPHYS_RETURN_IF_ERROR(CheckCount(count, "positions"));
  }
  return overlaps;
}

// Of several that are equally near, the first in canonical order.
ClosestPoints World::ClosestTo(const Shape& shape, const Placement& placement, double distance_max,
                               uint64_t collides_with_bits) {
  ClosestPoints closest;
  std::optional<GeometryRow> best;
  double within = distance_max;
  near_->VisitNearest(BoundsOf(shape, placement), within, [&](GeometryRow row) {
    WorkWatch::Spend(kGeometryWork);
    if (!rule_.SeenByRay(row, collides_with_bits)) return;
    const auto [geometry, there] = Placed(row);
    // What is as near as the best must be found to be told from it.
    const double reach = best ? std::nextafter(within, kInfinity) : within;
    const std::optional<Proximity> near = FindProximity(geometry->shape, there, shape, placement, reach);
    if (!near || (best && (near->distance > within || (near->distance == within && rule_.Before(*best, row))))) return;
    best = row;
    within = near->distance;
    closest = {{rule_.info(row).entity_id, geometry->id}, near->distance, near->on_b, near->on_a, near->normal};
  });
  return closest;
}

Result<std::vector<ClosestPoints>> World::FindClosest(const Shape& shape, std::span<const Pose> poses,
                                                      double distance_max, uint64_t collides_with_bits) {
  GENPHYS_RETURN_IF_ERROR(CheckShapeQuery(shape, poses));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(distance_max, 0, Limits::kRayLengthMax, "distance_max"));
  std::vector<ClosestPoints> closest(poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    WorkWatch::Spend(kShapeWork);
    closest[i] = ClosestTo(shape, PlacementOf(poses[i]), distance_max, collides_with_bits);
  }
  return closest;
}

Result<std::vector<ClosestPoints>> World::MeasureDistances(std::span<const EntityId> from,
                                                           std::span<const EntityId> to) const {
  if (from.size() != to.size()) {
    return Refuse(Reason::kInvalidValue, "to_ids", "there must be as many ids on either side");
  }
  std::vector<ClosestPoints> distances(from.size());
  for (size_t i = 0; i < from.size(); ++i) {
    GENPHYS_RETURN_IF_ERROR(CheckId(from[i], Cat("from_ids[", i, "]")));
    GENPHYS_RETURN_IF_ERROR(CheckId(to[i], Cat("to_ids[", i, "]")));
    WorkWatch::Spend(kShapeWork);
    for (const GeometryRow row : geometry_rows_[from[i].index()]) {
      const auto [geometry, placement] = Placed(row);
      for (const GeometryRow other_row : geometry_rows_[to[i].index()]) {
        WorkWatch::Spend(kGeometryWork);
        const auto [other, there] = Placed(other_row);
        const std::optional<Proximity> near = FindProximity(other->shape, there, geometry->shape, placement);
        ClosestPoints& best = distances[i];
        if (!near || (!best.hit.entity.is_null() && near->distance >= best.distance)) continue;
        best = {{to[i], other->id}, near->distance, near->on_b, near->on_a, near->normal};
      }
    }
  }
  return distances;
}

Result<std::vector<EntityContact>> World::ContactsOf(EntityId id) const {
  GENPHYS_RETURN_IF_ERROR(CheckId(id, "entity_id"));
  std::vector<EntityContact> contacts;
  const auto add = [&](const TouchingPair& touching) {
    if (touching.pair.a != id && touching.pair.b != id) return;
    WorkWatch::Spend(kTouchWork);
    EntityContact contact{touching.pair.a == id ? touching.pair.b : touching.pair.a, touching.is_sensor, {}};
    AddSolvedPoints(touching.pair, contact.points);
    if (contact.points.empty()) AddLastPoints(touching.pair, contact.points);
    if (contact.points.empty()) AddLyingPoints(touching.pair, contact.points);
    contacts.push_back(std::move(contact));
  };
  for (const TouchingPair& touching : layer_.touching) add(touching);
  layer_.lying.VisitOf(id, add);
  std::sort(contacts.begin(), contacts.end(), [](const EntityContact& a, const EntityContact& b) {
    return std::tie(a.other, a.is_sensor) < std::tie(b.other, b.is_sensor);
  });
  return contacts;
}

std::vector<EventContactPoint> World::SolvedPointsOf(const ContactPair& pair) const {
  std::vector<EventContactPoint> points;
  for (const ContactPoint& point : PointsOf(solved_, pair)) points.push_back(EventPointOf(rule_, pair, point));
  for (const SolvedPoint& turned : TurnedOf(solved_, pair)) {
    EventContactPoint& point = points[turned.point - pair.first_point];
    point.friction_impulse = turned.friction_impulse;
    point.relative_velocity = turned.relative_velocity;
  }
  return points;
}

void World::AddSolvedPoints(const EntityPair& entities, std::vector<EventContactPoint>& points) const {
  const auto ids = [&](const ContactPair& pair) {
    return EntityPair{state_.ids[Index(pair.entity_a)], state_.ids[Index(pair.entity_b)]};
  };
  for (const ContactPair& pair : std::ranges::equal_range(solved_.pairs, entities, {}, ids)) {
    const std::vector<EventContactPoint> solved = SolvedPointsOf(pair);
    points.insert(points.end(), solved.begin(), solved.end());
  }
}

void World::AddLastPoints(const EntityPair& entities, std::vector<EventContactPoint>& points) const {
  for (const auto& [sleeper, other] : {std::pair(entities.a, entities.b), std::pair(entities.b, entities.a)}) {
    // They were remembered in the order of the pairs that were solved, and that is the order of the others.
    const std::vector<LastTouch>& touches = layer_.last_touches[sleeper.index()];
    for (const LastTouch& touch : std::ranges::equal_range(touches, other, {}, &LastTouch::other)) {
      points.insert(points.end(), touch.points.begin(), touch.points.end());
    }
    if (!points.empty()) return;
  }
}

void World::RememberTouches(std::span<const EntityRow> sleepers) {
  if (sleepers.empty()) return;
  // Who was woken and has not been solved since still has those of its last sleep.
  for (const EntityRow row : sleepers) layer_.last_touches[Index(row)].clear();
  for (const ContactPair& pair : solved_.pairs) {
    if (pair.is_sensor) continue;
    for (const auto& [row, other] : {std::pair(pair.entity_a, pair.entity_b), {pair.entity_b, pair.entity_a}}) {
      if (!std::binary_search(sleepers.begin(), sleepers.end(), row)) continue;
      layer_.last_touches[Index(row)].push_back({state_.ids[Index(other)], SolvedPointsOf(pair)});
    }
  }
}

void World::AddLyingPoints(const EntityPair& entities, std::vector<EventContactPoint>& points) const {
  Manifold manifold;
  for (const GeometryRow row_a : geometry_rows_[entities.a.index()]) {
    for (const GeometryRow row_b : geometry_rows_[entities.b.index()]) {
      if (rule_.Decide(row_a, row_b) == PairRule::Verdict::kIgnore) continue;
      const auto [a, placement_a] = Placed(row_a);
      const auto [b, placement_b] = Placed(row_b);
      FindContacts(a->shape, placement_a, b->shape, placement_b, -kTouchingDepth, manifold);
      const MixedMaterial material = rule_.Mixed(row_a, row_b);
      for (int i = 0; i < manifold.count; ++i) {
        const MeetingPoint& point = manifold.points[static_cast<size_t>(i)];
        points.push_back({.position = point.position,
                          .normal = point.normal,
                          .depth = point.depth,
                          .friction = material.friction,
                          .restitution = material.restitution,
                          .geometry_a = a->id,
                          .geometry_b = b->id});
      }
    }
  }
}

}  // namespace genphys

#include "near_pairs.h"

#include <algorithm>

#include "genphys/bounds.h"
#include "genphys/placement.h"

namespace genphys {
namespace {

BroadPhase::HalfSpace HalfSpaceOf(const Plane& plane, const Placement& placement) {
  const Vector3 normal = placement.rotation * plane.normal;
  // Bounds are widened by half of the gap, and a plane has none that could be.
  return {normal, plane.offset + normal.dot(placement.position) + kContactGapMax};
}

Bounds WidenedBounds(const Shape& shape, const Placement& placement) {
  return BoundsOf(shape, placement).Widened(kContactGapMax / 2);
}

// Calls visit(geometry row, shape, placement) for each geometry of `member`.
template <typename Visit>
void VisitPlaced(const NearPairs::Member& member, const Pose& pose, Visit&& visit) {
  const Placement entity = ToPlacement(pose);
  for (size_t i = 0; i < member.geometries.size(); ++i) {
    const Geometry& geometry = member.body.geometries[i];
    visit(member.geometries[i], geometry.shape, PlacedIn(entity, geometry.pose_in_entity));
  }
}

NearPairs::Pair PairOf(const PairRule& rule, GeometryRow a, GeometryRow b) {
  const PairRule::GeometryInfo& info_a = rule.info(a);
  const PairRule::GeometryInfo& info_b = rule.info(b);
  return {.id_a = info_a.entity_id,
          .id_b = info_b.entity_id,
          .geometry_id_a = info_a.geometry_id,
          .geometry_id_b = info_b.geometry_id,
          .entity_a = info_a.entity,
          .entity_b = info_b.entity,
          .a = a,
          .b = b};
}

bool IsMoving(const RigidBody& body, bool is_active) { return is_active && body.motion_type != MotionType::kStatic; }

}  // namespace

void NearPairs::Add(const PairRule& rule, const Member& member, const Pose& pose, bool is_active) {
  static_assert(BoundsTree::kNoGroup == 0, "the number of no collision space");
  VisitPlaced(member, pose, [&](GeometryRow row, const Shape& shape, const Placement& placement) {
    if (const Plane* plane = std::get_if<Plane>(&shape)) {
      broad_phase_.AddHalfSpace(row, HalfSpaceOf(*plane, placement));
    } else {
      broad_phase_.Add(row, WidenedBounds(shape, placement), IsMoving(member.body, is_active), rule.info(row).space);
    }
  });
}

void NearPairs::Remove(std::span<const GeometryRow> geometries) {
  for (const GeometryRow row : geometries) broad_phase_.Remove(row);
}

void NearPairs::SetActive(const Member& member, bool is_active) {
  for (const GeometryRow row : member.geometries) broad_phase_.SetMoving(row, IsMoving(member.body, is_active));
}

void NearPairs::Place(const Member& member, const Pose& pose) {
  VisitPlaced(member, pose, [&](GeometryRow row, const Shape& shape, const Placement& placement) {
    if (const Plane* plane = std::get_if<Plane>(&shape)) {
      broad_phase_.MoveHalfSpace(row, HalfSpaceOf(*plane, placement));
    } else {
      broad_phase_.Move(row, WidenedBounds(shape, placement));
    }
  });
}

void NearPairs::Reserve(std::span<const GeometryRow> geometries, const Bounds& region) {
  for (const GeometryRow row : geometries) broad_phase_.Move(row, region.Widened(kContactGapMax / 2));
}

void NearPairs::Renew(std::span<const GeometryRow> geometries) {
  for (const GeometryRow row : geometries) broad_phase_.MarkFresh(row);
}

std::span<const NearPairs::Pair> NearPairs::Update(const PairRule& rule) {
  if (!broad_phase_.any_fresh()) return pairs_;
  std::erase_if(pairs_, [&](const Pair& pair) { return broad_phase_.IsFresh(pair.a) || broad_phase_.IsFresh(pair.b); });
  found_.clear();
  broad_phase_.VisitFreshPairs([&](GeometryRow a, GeometryRow b) { AddPair(rule, a, b); });
  broad_phase_.ForgetFresh();
  if (found_.empty()) return pairs_;
  std::sort(found_.begin(), found_.end());
  merged_.resize(pairs_.size() + found_.size());
  std::merge(pairs_.begin(), pairs_.end(), found_.begin(), found_.end(), merged_.begin());
  pairs_.swap(merged_);
  return pairs_;
}

void NearPairs::AddPair(const PairRule& rule, GeometryRow a, GeometryRow b) {
  const PairRule::Verdict verdict = rule.Decide(a, b);
  if (verdict == PairRule::Verdict::kIgnore) return;
  found_.push_back(rule.Before(a, b) ? PairOf(rule, a, b) : PairOf(rule, b, a));
  found_.back().is_sensor = verdict == PairRule::Verdict::kSensor;
}

void NearPairs::CollidePair(const PairRule& rule, BackendWorld& engine, const Pair& pair,
                            ContactBuffer& contacts) const {
  if (!MayTouch(pair)) return;
  const auto first = static_cast<uint32_t>(contacts.points.size());
  engine.FindPoints(pair.a, pair.b, contacts.points);
  const auto count = static_cast<uint32_t>(contacts.points.size()) - first;
  if (count == 0) return;
  contacts.pairs.push_back({.entity_a = pair.entity_a,
                            .entity_b = pair.entity_b,
                            .geometry_a = pair.a,
                            .geometry_b = pair.b,
                            .material = rule.Mixed(pair.a, pair.b),
                            .correction = rule.Correction(pair.a, pair.b),
                            .is_sensor = pair.is_sensor,
                            .first_point = first,
                            .point_count = count});
}

void NearPairs::Collide(const PairRule& rule, BackendWorld& engine, const RowMarks* moved, ContactBuffer& contacts) {
  Update(rule);
  std::swap(before_, contacts);
  contacts.Clear();
  // Both lists are in the same order, and all that is in `old` was near then.
  auto old = before_.pairs.begin();
  Pair old_pair;
  const auto take_old = [&] {
    if (old != before_.pairs.end()) old_pair = PairOf(rule, old->geometry_a, old->geometry_b);
  };
  if (moved != nullptr) take_old();
  for (const Pair& pair : pairs_) {
    if (moved == nullptr || (*moved)[pair.entity_a] || (*moved)[pair.entity_b]) {
      CollidePair(rule, engine, pair, contacts);
      continue;
    }
    for (; old != before_.pairs.end() && old_pair < pair; take_old()) ++old;
    if (old == before_.pairs.end() || old->geometry_a != pair.a || old->geometry_b != pair.b) continue;
    const auto first = before_.points.begin() + old->first_point;
    contacts.pairs.push_back(*old);
    contacts.pairs.back().first_point = static_cast<uint32_t>(contacts.points.size());
    contacts.points.insert(contacts.points.end(), first, first + old->point_count);
  }
}

}  // namespace genphys

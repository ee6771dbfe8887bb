#include "pairs/near_pairs.h"

#include <algorithm>
#include <cstddef>

#include "genphys/backend.h"
#include "genphys/bounds.h"
#include "genphys/placement.h"
#include "genphys/work_watch.h"
#include "model/cat.h"

namespace genphys {
namespace {

// Of a WorkWatch: to find that two are near each other, and to look where they touch.
constexpr int64_t kVisitWork = 4;
constexpr int64_t kTouchWork = 32;

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

void NearPairs::Reserve(std::span<const GeometryRow> geometries, const Bounds& region, bool is_first) {
  const auto course = is_first ? BroadPhase::Course::kPut : BroadPhase::Course::kReserved;
  for (const GeometryRow row : geometries) broad_phase_.Move(row, region.Widened(kContactGapMax / 2), course);
}

void NearPairs::Renew(std::span<const GeometryRow> geometries) {
  for (const GeometryRow row : geometries) broad_phase_.MarkFresh(row);
}

std::span<const NearPairs::Pair> NearPairs::Update(const PairRule& rule) {
  if (!broad_phase_.any_fresh()) return pairs_;
  std::erase_if(pairs_, [&](const Pair& pair) { return broad_phase_.IsFresh(pair.a) || broad_phase_.IsFresh(pair.b); });
  found_.clear();
  broad_phase_.VisitFreshPairs([&](GeometryRow a, GeometryRow b) { return AddPair(rule, a, b); });
  broad_phase_.ForgetFresh();
  if (found_.empty()) return pairs_;
  std::sort(found_.begin(), found_.end());
  merged_.resize(pairs_.size() + found_.size());
  std::merge(pairs_.begin(), pairs_.end(), found_.begin(), found_.end(), merged_.begin());
  pairs_.swap(merged_);
  return pairs_;
}

bool NearPairs::AddPair(const PairRule& rule, GeometryRow a, GeometryRow b) {
  WorkWatch::Spend(kVisitWork);
  const PairRule::Verdict verdict = rule.Decide(a, b);
  if (verdict == PairRule::Verdict::kIgnore) return false;
  CheckPairs(pairs_.size() + found_.size() + 1, budget_.pairs);
  found_.push_back(rule.Before(a, b) ? PairOf(rule, a, b) : PairOf(rule, b, a));
  found_.back().is_sensor = verdict == PairRule::Verdict::kSensor;
  return true;
}

void NearPairs::CheckPairs(size_t pairs, size_t most) {
  if (pairs > most) throw BudgetExceeded(Cat("more than ", most, " pairs of geometries are near each other"));
}

void NearPairs::CheckPoints(size_t points, size_t most) {
  if (points > most) throw BudgetExceeded(Cat("geometries touch at more than ", most, " points"));
}

void NearPairs::Check(const ContactBudget& budget, const ContactBuffer& contacts) const {
  CheckPairs(pairs_.size(), budget.pairs);
  CheckPoints(contacts.points.size(), budget.points);
}

ContactPair NearPairs::Opened(const PairRule& rule, const Pair& pair, const ContactBuffer& contacts) {
  return {.entity_a = pair.entity_a,
          .entity_b = pair.entity_b,
          .geometry_a = pair.a,
          .geometry_b = pair.b,
          .material = rule.Mixed(pair.a, pair.b),
          .correction = rule.Correction(pair.a, pair.b),
          .is_sensor = pair.is_sensor,
          .first_point = static_cast<uint32_t>(contacts.points.size())};
}

void NearPairs::Collide(const PairRule& rule, BackendWorld& engine, ContactBuffer& contacts) {
  Update(rule);
  contacts.Clear();
  is_scattered_ = false;
  for (const Pair& pair : pairs_) {
    if (!MayTouch(pair)) continue;
    const auto first = contacts.points.size();
    WorkWatch::Spend(kTouchWork);
    engine.FindPoints(pair.a, pair.b, contacts.points);
    const auto count = static_cast<uint32_t>(contacts.points.size() - first);
    if (count == 0) continue;
    CheckPoints(contacts.points.size(), budget_.points);
    ContactPair& touching = contacts.pairs.emplace_back(Opened(rule, pair, contacts));
    touching.first_point -= count;
    touching.point_count = count;
  }
}

void NearPairs::CollideMoved(const PairRule& rule, BackendWorld& engine, const RowMarks& moved,
                             ContactBuffer& contacts) {
  Update(rule);
  const auto is_moved = [&](const auto& pair) { return moved[pair.entity_a] || moved[pair.entity_b]; };
  std::vector<ContactPair>& known = contacts.pairs;
  size_t next = 0;
  bool any_gone = false;
  // Of those that moved, both lists are in the same order.
  const auto pass_unmoved = [&] {
    while (next < known.size() && !is_moved(known[next])) ++next;
  };
  const auto let_go = [&] {
    known[next++].point_count = 0;
    any_gone = true;
    pass_unmoved();
  };
  come_.clear();
  pass_unmoved();
  for (const Pair& pair : pairs_) {
    if (!is_moved(pair)) continue;
    const auto is_this = [&] { return known[next].geometry_a == pair.a && known[next].geometry_b == pair.b; };
    while (next < known.size() && !is_this() && PairOf(rule, known[next].geometry_a, known[next].geometry_b) < pair) {
      let_go();
    }
    const bool is_known = next < known.size() && is_this();
    points_.clear();
    WorkWatch::Spend(kTouchWork);
    if (MayTouch(pair)) engine.FindPoints(pair.a, pair.b, points_);
    if (points_.empty()) {
      if (is_known) let_go();
      continue;
    }
    ContactPair renewed = Opened(rule, pair, contacts);
    CheckPoints(contacts.points.size(), budget_.points);
    if (!is_known) {
      Overwrite(points_, renewed, contacts);
      come_.push_back(renewed);
      continue;
    }
    renewed.first_point = known[next].first_point;
    renewed.point_count = known[next].point_count;
    Overwrite(points_, renewed, contacts);
    known[next++] = renewed;
    pass_unmoved();
  }
  while (next < known.size()) let_go();
  if (any_gone) std::erase_if(known, [](const ContactPair& pair) { return pair.point_count == 0; });
  is_scattered_ |= any_gone;
  Insert(rule, contacts);
}

// Gives a pair these points, in the place of those that it has if there are no more of them.
void NearPairs::Overwrite(const std::vector<ContactPoint>& points, ContactPair& pair, ContactBuffer& contacts) {
  const auto count = static_cast<uint32_t>(points.size());
  is_scattered_ |= count != pair.point_count;
  if (count <= pair.point_count) {
    std::copy(points.begin(), points.end(), contacts.points.begin() + pair.first_point);
  } else {
    pair.first_point = static_cast<uint32_t>(contacts.points.size());
    contacts.points.insert(contacts.points.end(), points.begin(), points.end());
  }
  pair.point_count = count;
}

// Sorts who came in among the pairs, from the last one on, so that each is moved once.
void NearPairs::Insert(const PairRule& rule, ContactBuffer& contacts) {
  std::vector<ContactPair>& pairs = contacts.pairs;
  size_t from = pairs.size(), to = from + come_.size();
  pairs.resize(to);
  const auto before = [&](const Pair& key, const ContactPair& pair) {
    return key < PairOf(rule, pair.geometry_a, pair.geometry_b);
  };
  for (; !come_.empty(); come_.pop_back()) {
    const Pair key = PairOf(rule, come_.back().geometry_a, come_.back().geometry_b);
    const auto place = std::upper_bound(pairs.begin(), pairs.begin() + static_cast<ptrdiff_t>(from), key, before);
    const auto first = static_cast<size_t>(place - pairs.begin());
    while (from > first) pairs[--to] = pairs[--from];
    pairs[--to] = come_.back();
  }
}

void NearPairs::PutInOrder(ContactBuffer& contacts) {
  if (!is_scattered_) return;
  is_scattered_ = false;
  points_.clear();
  points_.reserve(contacts.points.size());
  for (ContactPair& pair : contacts.pairs) {
    const auto first = contacts.points.begin() + pair.first_point;
    pair.first_point = static_cast<uint32_t>(points_.size());
    points_.insert(points_.end(), first, first + pair.point_count);
  }
  std::swap(points_, contacts.points);
}

}  // namespace genphys

#include "impacts/bearings.h"

#include <algorithm>
#include <numeric>

#include "pairs/contact_points.h"

namespace genphys {
namespace {

// The cosine between what pulls and a normal from which on one bears the other; less is a neighbour.
constexpr double kBearing = 0.2;

}  // namespace

// Of pairs that touch and of which a solve knows nothing yet: neither on what those lie that were woken just now, nor
// whether a neighbour whom they touch presses. Who moved and touches one of these only now was its waker.
template <typename Visit>
void Bearings::VisitWoken(const ContactBuffer& contacts, Visit visit) const {
  const auto touches = [](const ContactPoint& point) { return point.depth >= kTouchingDepth; };
  const auto has_moved = [&](EntityRow row) { return past_.IsMovable(row) && !past_.IsWoken(row); };
  for (const ContactPair& pair : contacts.pairs) {
    if (!IsWoken(pair.entity_a) && !IsWoken(pair.entity_b)) continue;
    if (pair.is_sensor || has_moved(pair.entity_a) || has_moved(pair.entity_b)) continue;
    if (std::ranges::any_of(PointsOf(contacts, pair), touches)) visit(pair);
  }
}

void Bearings::FindStances(const ContactBuffer& contacts, bool is_anybody_woken) {
  if (!knows_stances_) {
    knows_stances_ = true;
    for (const ContactPair& pair : world_.solved.pairs) {
      if (!pair.is_sensor && HasPressed(world_.solved, pair)) NoteStance(pair);
    }
  }
  if (!is_anybody_woken) return;
  is_found_ = false;
  VisitWoken(contacts, [&](const ContactPair& pair) {
    if (BorneIn(contacts, pair, false) != std::pair(false, false)) NoteStance(pair);
  });
}

void Bearings::NoteStance(const ContactPair& pair) {
  const bool is_movable_a = past_.IsMovable(pair.entity_a), is_movable_b = past_.IsMovable(pair.entity_b);
  const uint8_t stance = is_movable_a && is_movable_b ? kAmongOthers : kOnGround;
  if (is_movable_a) world_.stances[pair.entity_a] |= stance;
  if (is_movable_b) world_.stances[pair.entity_b] |= stance;
}

std::pair<bool, bool> Bearings::BorneIn(const ContactBuffer& contacts, const ContactPair& pair,
                                        bool has_pressed) const {
  Vector3 push = Vector3::Zero();  // on b
  for (const ContactPoint& point : PointsOf(contacts, pair)) {
    const bool touches = !has_pressed && point.depth >= kTouchingDepth;
    push += (has_pressed ? point.normal_impulse : touches ? 1.0 : 0.0) * point.normal;
  }
  bool is_borne_a = past_.IsMovable(pair.entity_a), is_borne_b = past_.IsMovable(pair.entity_b);
  if (is_borne_a && is_borne_b) {
    const Vector3 &pull_a = world_.accelerations[pair.entity_a], &pull_b = world_.accelerations[pair.entity_b];
    const double up = -(pull_a + pull_b).dot(push);
    const double level = kBearing * (pull_a.norm() + pull_b.norm()) * push.norm();
    is_borne_a = up < -level;
    is_borne_b = up > level;
  }
  return {is_borne_a, is_borne_b};
}

void Bearings::Note(const ContactBuffer& contacts, const ContactPair& pair, bool has_pressed) {
  const auto [is_borne_a, is_borne_b] = BorneIn(contacts, pair, has_pressed);
  if (is_borne_a) bearings_.push_back({pair.entity_a, pair.entity_b, pair});
  if (is_borne_b) bearings_.push_back({pair.entity_b, pair.entity_a, pair});
}

void Bearings::Find(const ContactBuffer& contacts) {
  if (std::exchange(is_found_, true)) return;
  bearings_.clear();
  for (const ContactPair& pair : world_.solved.pairs) {
    if (!pair.is_sensor && HasPressed(world_.solved, pair)) Note(world_.solved, pair, true);
  }
  VisitWoken(contacts, [&](const ContactPair& pair) { Note(contacts, pair, false); });
  order_.resize(bearings_.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::sort(order_, {}, [&](uint32_t i) { return std::pair(bearings_[i].borne, i); });
}

std::span<const uint32_t> Bearings::Of(EntityRow row) const {
  const auto found = std::ranges::equal_range(order_, row, {}, [&](uint32_t i) { return bearings_[i].borne; });
  return {found.begin(), found.end()};
}

bool Bearings::IsHitFromAbove(const ContactBuffer& contacts, const ContactPair& hit, EntityRow row) const {
  const bool is_a = row == hit.entity_a;
  if (hit.point_count > 0) {
    const auto [is_borne_a, is_borne_b] = BorneIn(contacts, hit, false);
    return is_a ? is_borne_b : is_borne_a;
  }
  const auto center = [&](EntityRow of) {
    return world_.state.pose(of).Transform(world_.scene.entities[Index(of)]->mass.center_of_mass);
  };
  const Vector3 up = center(is_a ? hit.entity_b : hit.entity_a) - center(row);
  return up.dot(world_.accelerations[row]) < 0;
}

}  // namespace genphys

// What stands on the ground and is hit. The ground takes part in the blow, so that nothing is driven into it, and the
// body goes back to the time of the blow like one that flies, for it may be thrown along the ground then.
#include <algorithm>
#include <limits>

#include "impacts/impacts.h"
#include "pairs/contact_points.h"

namespace genphys {
namespace {

// Of what joints hold together so many points where it is borne take part in a blow, those of the nearest bodies: with
// the blow itself they are few enough to be solved at once, and of what joints pass on little comes far where all on
// the way are borne.
constexpr size_t kBornePointsMost = 28;

}  // namespace

// Adds on what those stand that are struck.
void Impacts::AddSupports(const ContactBuffer& contacts) {
  supports_.clear();
  AddGround(contacts);
  AddBearers(contacts);
  for (const Candidate& support : supports_) {
    NumberOf(support.pair.entity_a);
    NumberOf(support.pair.entity_b);
  }
}

// Whether what bears it takes part in what hits it.
bool Impacts::IsBorne(EntityRow row) const { return past_.StandsOnGround(row) || IsTied(row); }

// What moves, and not as joints let it together with that one.
bool Impacts::IsMovedApart(EntityRow bearer, EntityRow row) const {
  return past_.IsMovable(bearer) && (!IsTied(row) || GroupOf(bearer) != GroupOf(row));
}

// Whether b takes part in what hits a, or a in what hits b: what nothing can move, and for what joints hold together
// all of that, which goes back as one whatever it touches, and whoever bears it.
bool Impacts::Bears(const ContactBuffer& contacts, const ContactPair& pair, bool is_a) const {
  const EntityRow row = is_a ? pair.entity_a : pair.entity_b, bearer = is_a ? pair.entity_b : pair.entity_a;
  if (std::as_const(world_.struck_index)[row] < 0 || !IsBorne(row)) return false;
  if (!IsMovedApart(bearer, row)) return true;
  if (!IsTied(row) || !rewinds_) return false;
  const auto [is_borne_a, is_borne_b] = bearings_.BorneIn(contacts, pair, false);
  return is_a ? is_borne_a : is_borne_b;
}

void Impacts::AddGround(const ContactBuffer& contacts) {
  if (std::ranges::none_of(struck_, [&](const Struck& struck) { return IsBorne(struck.row); })) return;
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    const bool is_a = Bears(contacts, pair, true);
    if (!is_a && !Bears(contacts, pair, false)) continue;
    if (CandidateOf(pair.geometry_a, pair.geometry_b) != nullptr) continue;
    const EntityRow borne = is_a ? pair.entity_a : pair.entity_b, bearer = is_a ? pair.entity_b : pair.entity_a;
    Candidate& support =
        supports_.emplace_back(Candidate{.pair = pair, .time = struck_[NumberOf(borne)].time, .is_held = true});
    support.is_passed_down = IsMovedApart(bearer, borne);
    if (support.is_passed_down) support.borne = is_a ? Borne::kA : Borne::kB;
  }
  if (supports_.empty()) return;
  for (const Group& group : groups_) {
    if (group.is_tied) ChooseSupports(group);
  }
}

// What something that moves by itself presses against what nothing moves, or against another such thing, has nowhere to
// go, and no impulses let it: what bears it is left to the next solve.
bool Impacts::IsSqueezed(const Group& group) const {
  EntityRow known = kWorldRow;
  bool are_several = false, is_driven = false;
  const auto note = [&](EntityRow row, EntityRow other) {
    if (GroupOf(row) != &group || past_.IsMovable(other)) return;
    are_several |= known != kWorldRow && known != other;
    known = other;
    const uint32_t column = Index(other);
    is_driven |= !world_.state.linear_velocities.col(column).isZero(0);
    is_driven |= !world_.state.angular_velocities.col(column).isZero(0);
  };
  for (const std::vector<Candidate>* const pairs : {&candidates_, &supports_}) {
    for (const Candidate& each : *pairs) {
      note(each.pair.entity_a, each.pair.entity_b);
      note(each.pair.entity_b, each.pair.entity_a);
    }
  }
  return (are_several && is_driven) || (known != kWorldRow && ties_.IsDriven(group.members.front()));
}

// Leaves of the supports of the group those that can take part.
void Impacts::ChooseSupports(const Group& group) {
  const auto is_of = [&](EntityRow row) { return GroupOf(row) == &group; };
  const auto others = std::ranges::stable_partition(supports_, [&](const Candidate& support) {
    return !is_of(support.pair.entity_a) && !is_of(support.pair.entity_b);
  });
  if (others.empty()) return;
  if (IsSqueezed(group)) {
    supports_.erase(others.begin(), others.end());
    return;
  }
  std::vector<Vector3> hits;
  for (const Candidate& candidate : candidates_) {
    for (const EntityRow row : {candidate.pair.entity_a, candidate.pair.entity_b}) {
      if (is_of(row)) hits.push_back(world_.state.positions.col(Index(row)));
    }
  }
  std::ranges::stable_sort(others, {}, [&](const Candidate& support) {
    const EntityRow row = is_of(support.pair.entity_a) ? support.pair.entity_a : support.pair.entity_b;
    const Vector3 position = world_.state.positions.col(Index(row));
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3& hit : hits) least = std::min(least, (hit - position).squaredNorm());
    return least;
  });
  size_t points = 0;
  const auto is_too_far = [&](const Candidate& support) {
    return (points += support.pair.point_count) > kBornePointsMost;
  };
  supports_.erase(std::ranges::find_if(others, is_too_far), others.end());
}

// To blows on those that they bear.
void Impacts::AddSupportBlows() {
  if (blows_.empty() || supports_.empty()) return;
  const size_t count = blows_.size();
  for (const Candidate& support : supports_) {
    // A corner that stands a little off takes part, too: else what is hit would tip over the others.
    Manifold manifold;
    past_.FindMeeting(support.pair, support.time, support.time, -kTouchingDepth, manifold);
    for (const MeetingPoint& point : std::span(manifold.points).first(static_cast<size_t>(manifold.count))) {
      AddBlow(support, point.position, point.normal);
    }
  }
  // Who was thought to be hit and is not leaves them alone.
  std::vector<uint8_t> bears(blows_.size(), true);
  VisitTogether([&](std::span<const uint32_t> together) {
    const bool are_alone = std::ranges::all_of(together, [&](uint32_t i) { return i >= count; });
    for (const uint32_t i : together) bears[i] = !are_alone;
  });
  KeepBlows([&](size_t i) { return bears[i] != 0; });
}

}  // namespace genphys

// What lies among others and is hit by something that flies: those that bear it bear the blow, too, down to the ground.
// They stay where they are, and what the blow makes of their velocities is all.
#include <algorithm>
#include <utility>

#include "impacts/impacts.h"
#include "pairs/contact_points.h"
#include "pairs/disjoint_sets.h"

namespace genphys {
namespace {

// Bodies to which hits that share some of these are passed on, and such hits, at most: they are passed on to all that
// bear what is hit, or to nobody. In a pile that falls ever more hits hang together, and are over in the next substep:
// without a bound the steps of 216 boxes that fall on each other cost a twentieth more, with this one a hundredth.
constexpr size_t kPassedMost = 64;
constexpr size_t kHitsMost = 8;

}  // namespace

// Whether it lies among others and is pushed against them, and one of the two would go at the speed of an impact: what
// flies is thrown back, and what is hit goes into what bears it. All that is slower comes to rest in the next solve.
bool Impacts::IsPassedOn(const ContactBuffer& contacts, const Candidate& candidate, EntityRow row) const {
  if (IsTied(row)) return false;  // all that joints hold together with it passes on what hits it
  const ContactPair& pair = candidate.pair;
  const EntityRow other = row == pair.entity_a ? pair.entity_b : pair.entity_a;
  const auto stance = [&](EntityRow of) { return std::as_const(world_.stances)[of]; };
  if (!(stance(row) & kAmongOthers) || stance(other) != 0 || !past_.IsMovable(other)) return false;
  const auto mass = [&](EntityRow of) { return world_.scene.entities[Index(of)]->mass.mass; };
  const double part = IsTied(other) ? 1 : mass(other) / (mass(other) + mass(row));
  const double restitution = pair.material.restitution;
  const double fastest = std::max(restitution, (1 + restitution) * part) * candidate.closing;
  const Vector3& pull = std::as_const(world_.accelerations)[row];
  return fastest > speed_.Of(pair.entity_a, pair.entity_b, pull.normalized()) &&
         bearings_.IsHitFromAbove(contacts, pair, row);
}

// Those that bear `row`, and itself, and all that joints hold together with any of them. What is hit takes part anyway.
bool Impacts::FollowDown(EntityRow row, int number, Descent& descent) {
  const int known = std::as_const(world_.passed_index)[row];
  if (known >= 0) {
    if (known != number) descent.shares_with.push_back(known);
    return true;
  }
  if (!past_.IsMovable(row) || IsTied(row)) {
    descent.is_grounded = true;
    return true;
  }
  std::vector<EntityRow> linked;
  std::span<const EntityRow> rows(&row, 1);
  if (world_.jointed[row]) {
    if (GroupOf(row) != nullptr) return false;
    descent.groups.push_back(AddGroup(row));
    rows = linked = groups_.back().linked.rows;
  }
  if (descent.passed.size() + rows.size() > kPassedMost) return false;
  for (const EntityRow each : rows) world_.passed_index[each] = number;
  for (const EntityRow each : rows) {
    for (const uint32_t i : bearings_.Of(each)) {
      if (!FollowDown(bearings_[i].bearer, number, descent)) return false;
    }
  }
  descent.passed.insert(descent.passed.end(), rows.begin(), rows.end());
  return true;
}

// Adds what bears those that are struck among others.
void Impacts::AddBearers(const ContactBuffer& contacts) {
  if (!rewinds_) return;
  std::vector<Descent> descents;
  const auto descend = [&](Descent& descent, EntityRow row) {
    bearings_.Find(contacts);
    const int number = static_cast<int>(&descent - descents.data());
    descent.is_whole = FollowDown(row, number, descent) && descent.is_whole;
  };
  for (Candidate& candidate : candidates_) {
    for (const EntityRow row : {candidate.pair.entity_a, candidate.pair.entity_b}) {
      if (!IsPassedOn(contacts, candidate, row)) continue;
      descend(descents.emplace_back(Descent{.candidate = &candidate, .hit = row}), row);
    }
  }
  for (int group = 0, count = static_cast<int>(groups_.size()); group < count; ++group) {
    for (const Candidate& support : supports_) {
      const bool is_a = support.borne == Borne::kA;
      const EntityRow borne = is_a ? support.pair.entity_a : support.pair.entity_b;
      if (!support.is_passed_down || std::as_const(world_.group_of)[borne] != group) continue;
      if (descents.empty() || descents.back().group != group) descents.push_back({.group = group});
      descend(descents.back(), is_a ? support.pair.entity_b : support.pair.entity_a);
    }
  }
  world_.passed_index.Clear();
  if (descents.empty()) return;
  DisjointSets sets(descents.size());
  for (uint32_t i = 0; i < descents.size(); ++i) {
    for (const int other : descents[i].shares_with) sets.Join(i, static_cast<uint32_t>(other));
  }
  std::vector<size_t> hits(descents.size()), bodies(descents.size());
  std::vector<bool> are_grounded(descents.size());
  for (uint32_t i = 0; i < descents.size(); ++i) {
    const uint32_t root = sets.Find(i);
    ++hits[root];
    bodies[root] += descents[i].is_whole ? descents[i].passed.size() : kPassedMost + 1;
    if (descents[i].is_grounded) are_grounded[root] = true;
  }
  // Whom others bear come after those.
  for (uint32_t i = static_cast<uint32_t>(descents.size()); i-- > 0;) {
    const uint32_t root = sets.Find(i);
    const int group = descents[i].group;
    // What falls together with what is on it has borne nothing.
    const bool are_borne = group < 0 || are_grounded[root];
    if (hits[root] <= kHitsMost && bodies[root] <= kPassedMost && are_borne) {
      AddBearers(descents[i]);
    } else if (group >= 0) {
      DropBearers(group);
    }
  }
}

void Impacts::AddBearers(const Descent& descent) {
  if (descent.candidate != nullptr) {
    const bool is_a = descent.hit == descent.candidate->pair.entity_a;
    descent.candidate->borne = is_a ? Borne::kB : Borne::kA;
  }
  for (const size_t group : descent.groups) TieAll(groups_[group]);
  for (size_t k = descent.passed.size(); k-- > 0;) {
    const EntityRow row = descent.passed[k];
    const int number = std::as_const(world_.struck_index)[row];
    const double time = number >= 0 ? struck_[static_cast<size_t>(number)].time : 0;
    for (const uint32_t i : bearings_.Of(row)) {
      const ContactPair& pair = bearings_[i].pair;
      if (CandidateOf(pair.geometry_a, pair.geometry_b) != nullptr) continue;
      const Borne borne = row == pair.entity_a ? Borne::kA : Borne::kB;
      supports_.push_back({.pair = pair, .time = time, .is_held = true, .borne = borne});
    }
  }
}

// Those to whom nothing is passed on from what joints hold together.
void Impacts::DropBearers(int group) {
  std::erase_if(supports_, [&](const Candidate& support) {
    const EntityRow borne = support.borne == Borne::kA ? support.pair.entity_a : support.pair.entity_b;
    return support.is_passed_down && std::as_const(world_.group_of)[borne] == group;
  });
}

}  // namespace genphys

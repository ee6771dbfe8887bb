#include "contacts/grips.h"

#include <algorithm>

namespace genphys {
namespace {

// The part of what friction may do from which on a pair bears a load along its surfaces.
constexpr double kLoaded = 0.05;
// The same of what lies on the ground. A tower that is held in both directions by less comes to rest elsewhere.
constexpr double kLoadedOnGround = 0.02;
// The same of half of the points, up to which these may hold alone what all of them do.
constexpr double kSharedMax = 0.8;
// Cosine between normals of one surface.
constexpr double kSameSurface = 0.999;

bool AreOnALine(std::span<const Vector3> places) {
  // Of the length: more than rounding leaves of a line that a mesh cuts in pieces, and less than any box is wide.
  constexpr double kOff = 1e-3;
  if (places.size() <= 2) return true;
  const auto from_first = [&](const Vector3& place) -> Vector3 { return place - places[0]; };
  const Vector3 along = from_first(
      *std::ranges::max_element(places, {}, [&](const Vector3& place) { return from_first(place).squaredNorm(); }));
  const double most = kOff * along.squaredNorm();
  return std::ranges::all_of(
      places, [&](const Vector3& place) { return from_first(place).cross(along).squaredNorm() <= most * most; });
}

}  // namespace

void Grips::Find(std::span<const AddedPair> pairs, std::span<const SweptBody> bodies, bool all_at_once, bool are_few) {
  groups_.clear();
  members_.clear();
  grips_.clear();
  ForgetGroups();
  for (const AddedPair& pair : pairs) Add(pair, are_few);
  for (const Group& group : groups_) {
    const AddedPair& any = pairs[group.first];
    Grip& grip = grips_.emplace_back();
    const double held = group.braked.norm();
    grip.is_on_a_line = IsOnALine(pairs, group);
    grip.is_on_ground = are_few && !grip.is_on_a_line && !(bodies[any.a].is_dynamic && bodies[any.b].is_dynamic);
    grip.bears = held > (grip.is_on_ground ? kLoadedOnGround : kLoaded) * (group.most[0] + group.most[1]);
    // Where one half presses in another place than the other, nothing may hold what turns. Few points need not save
    // rows.
    grip.may_share = held <= kSharedMax * 2 * std::min(group.most[0], group.most[1]) && !all_at_once && !are_few;
    grip.load = held;
    grip.braked = group.braked;
    grip.count = static_cast<double>(std::max<size_t>(group.count, 1));
  }
}

// A table is cleared place by place, and a step of few must not pay for how many were awake before.
void Grips::ForgetGroups() {
  constexpr size_t kPlacesPerPair = 16;
  if (group_of_.bucket_count() > kPlacesPerPair * (group_of_.size() + 1)) {
    group_of_ = decltype(group_of_)();  // an empty list would leave it as large as it is
  } else {
    group_of_.clear();
  }
}

Grip Grips::Of(size_t pair) const {
  const Member& member = members_[pair];
  Grip grip = grips_[member.group];
  grip.braked *= member.sign;
  return grip;
}

void Grips::Add(const AddedPair& pair, bool is_of_few) {
  const size_t number = members_.size();
  // Of what cannot be moved it does not matter which it is.
  const double sign = pair.b == ContactSweeps::kFixed ? -1 : 1;
  const Sides sides = pair.b == ContactSweeps::kFixed ? Sides(pair.b, pair.a) : Sides(pair.a, pair.b);
  const Vector3 normal = pair.points.empty() ? Vector3(Vector3::Zero()) : Vector3(sign * pair.points[0].normal);
  const size_t place = GroupOf(pair, sides, normal, is_of_few);
  Group& group = groups_[place];
  if (group.count == 0) {
    group.first = number;
  } else {
    members_[group.last].next = number;
  }
  group.last = number;
  members_.push_back({place, sign});
  for (size_t i = 0; i < pair.points.size(); ++i) {
    group.braked += sign * pair.impulses[i].friction;
    group.most[i % 2] += pair.points[i].friction * pair.impulses[i].normal;
  }
  group.count += pair.points.size();
}

// Of more than few points each pair is alone.
size_t Grips::GroupOf(const AddedPair& pair, const Sides& sides, const Vector3& normal, bool is_of_few) {
  const size_t fresh = groups_.size();
  if (is_of_few && !pair.points.empty()) {
    const auto [known, is_new] = group_of_.try_emplace(sides, fresh);
    for (size_t place = is_new ? kNone : known->second; place != kNone; place = groups_[place].next_group) {
      if (groups_[place].normal.dot(normal) > kSameSurface) return place;
      if (groups_[place].next_group == kNone) {
        groups_[place].next_group = fresh;
        break;
      }
    }
  }
  groups_.push_back({.normal = normal});
  return fresh;
}

bool Grips::IsOnALine(std::span<const AddedPair> pairs, const Group& group) {
  places_.clear();
  for (size_t pair = group.first; pair != kNone; pair = members_[pair].next) {
    for (const ContactPoint& point : pairs[pair].points) places_.push_back(point.position);
  }
  return AreOnALine(places_);
}

}  // namespace genphys

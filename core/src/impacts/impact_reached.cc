// Who takes part in a blow of others: of impacts that are close in time not all happen.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "impacts/blow_groups.h"
#include "impacts/impacts.h"
#include "motion/free_rotation.h"

namespace genphys {
namespace {

// m: two that meet somebody at once are as near to it but for this.
constexpr double kRounding = 1e-9;
// Of the gap between two: by less than this they miss each other if they come together as it seemed.
constexpr double kStraight = 0.1;
// m: what is reached is looked at this much later again, and less than this part of that deeper it is level.
constexpr double kLookAhead = 1e-5;
constexpr double kLevelPart = 0.25;
// rad: between faces that are one.
constexpr double kLevel = 1e-6;

// Whether one of `others` hits what moves of `blow` in the same direction.
bool IsLevelWithAny(const Blow& blow, std::span<const Blow> others, std::span<const StruckBody> bodies) {
  return std::ranges::any_of(others, [&](const Blow& other) {
    const auto hits = [&](uint32_t body) {
      return bodies[body].inverse_mass > 0 && (other.body_a == body || other.body_b == body);
    };
    return (hits(blow.body_a) || hits(blow.body_b)) && other.normal.cross(blow.normal).squaredNorm() < kLevel * kLevel;
  });
}

}  // namespace

double Impacts::GapOf(std::span<const MeetingPoint> points) {
  double gap = std::numeric_limits<double>::infinity();
  for (const MeetingPoint& point : points) gap = std::min(gap, -point.depth);
  return gap;
}

// Of impacts at once not all are: who is further from somebody than from others when these hit it comes to there only
// if it goes there after that, and else has its turn when it does. What flies at a tile beside a seam is not thrown
// back by the edge of the next one, which is behind.
void Impacts::DropUnreached() {
  if (candidates_.size() < 2 || !FindApart()) return;
  std::vector<Blow> first = BlowsBesideApart();
  std::vector<StruckBody> after = bodies_;
  Restitute(first, after, ties_);
  for (Candidate& candidate : candidates_) candidate.is_apart = candidate.is_apart && !Reaches(candidate, after);
  // What lands flat on several does so as on one.
  KeepBlows([&](size_t i) { return !blow_pairs_[i]->is_apart || IsLevelWithAny(blows_[i], first, bodies_); });
}

// Those for which `stays` says so.
void Impacts::KeepBlows(absl::FunctionRef<bool(size_t)> stays) {
  size_t kept = 0;
  for (size_t i = 0; i < blows_.size(); ++i) {
    if (!stays(i)) continue;
    blows_[kept] = blows_[i];
    blow_pairs_[kept++] = blow_pairs_[i];
  }
  blows_.resize(kept);
  blow_pairs_.resize(kept);
}

// Calls visit(blows), their numbers, for each of the groups that have no body in common that can move.
void Impacts::VisitTogether(absl::FunctionRef<void(std::span<const uint32_t>)> visit) const {
  std::vector<uint32_t> together;
  BlowGroups(blows_, bodies_, ties_)
      .Walk([&](uint32_t i) { together.push_back(i); },
            [&] {
              visit(together);
              together.clear();
            });
}

// Those that happen, of all that hang together with somebody who may not be reached.
std::vector<Blow> Impacts::BlowsBesideApart() {
  std::vector<Blow> beside;
  const auto is_apart = [&](uint32_t i) { return blow_pairs_[i]->is_apart; };
  VisitTogether([&](std::span<const uint32_t> together) {
    if (std::ranges::none_of(together, is_apart)) return;
    for (const uint32_t i : together) {
      if (!is_apart(i)) Ask(beside.emplace_back(blows_[i]), blow_pairs_[i]->pair);
    }
  });
  return beside;
}

// Says so of candidates. Returns whether there are any.
bool Impacts::FindApart() {
  const auto struck_in = [&](const Candidate& candidate) {
    const auto of = [&](EntityRow row) { return &struck_[static_cast<size_t>(world_.struck_index[row])]; };
    return std::array{of(candidate.pair.entity_a), of(candidate.pair.entity_b)};
  };
  for (const Candidate& candidate : candidates_) {
    if (!candidate.is_timed) continue;
    for (Struck* const struck : struck_in(candidate)) struck->gap = std::min(struck->gap, candidate.gap);
  }
  bool are_any = false;
  for (Candidate& candidate : candidates_) {
    if (!candidate.is_timed) continue;
    candidate.nearest = candidate.gap;
    for (const Struck* const struck : struck_in(candidate)) {
      if (struck->motion.is_movable()) candidate.nearest = std::min(candidate.nearest, struck->gap);
    }
    candidate.is_apart = candidate.gap > candidate.nearest + kRounding;
    are_any = are_any || candidate.is_apart;
  }
  return are_any;
}

// Whether the two come as near to each other as those that hit, if they go on like this: at once, and as straight as
// between two that lie flat on each other, not past an edge, nor over it onto what is level.
bool Impacts::Reaches(const Candidate& candidate, std::span<const StruckBody> after) const {
  const ContactPair& pair = candidate.pair;
  const auto placed = [&](EntityRow entity, GeometryRow geometry, double time) {
    const auto i = static_cast<size_t>(world_.struck_index[entity]);
    Pose pose = struck_[i].motion.PoseBefore(struck_[i].time);
    const Quaternion turn = Turned(Quaternion::Identity(), after[i].angular_velocity, time);
    pose.position = after[i].center + time * after[i].linear_velocity + turn * (pose.position - after[i].center);
    pose.orientation = turn * pose.orientation;
    return ToPlacement(pose.Transform(past_.GeometryAt(geometry).pose_in_entity));
  };
  const auto meet = [&](double time, Manifold& manifold) {
    FindContacts(past_.GeometryAt(pair.geometry_a).shape, placed(pair.entity_a, pair.geometry_a, time),
                 past_.GeometryAt(pair.geometry_b).shape, placed(pair.entity_b, pair.geometry_b, time),
                 kFlatGap + kFlatPart * candidate.closing * step_size_, manifold);
    return std::span<const MeetingPoint>(manifold.points).first(static_cast<size_t>(manifold.count));
  };
  const auto velocity = [&](EntityRow row, const MeetingPoint& point) {
    return after[static_cast<size_t>(world_.struck_index[row])].VelocityAt(point.position);
  };
  Manifold manifold;
  const std::span<const MeetingPoint> points = meet(0, manifold);
  const double way = GapOf(points) - candidate.nearest;
  double closing = 0;
  for (const MeetingPoint& point : points) {
    closing = std::max(closing, (velocity(pair.entity_a, point) - velocity(pair.entity_b, point)).dot(point.normal));
  }
  // Of nobody it is known how near those are that hit, if they have no points.
  if (!std::isfinite(way) || !(way < kSameTime * step_size_ * closing)) return false;
  if (!(GapOf(meet(way / closing, manifold)) - candidate.nearest < kStraight * way)) return false;
  return GapOf(meet((way + kLookAhead) / closing, manifold)) - candidate.nearest < -kLevelPart * kLookAhead;
}

}  // namespace genphys

// Who takes part in a blow of others: of impacts that are close in time not all happen.
#include <algorithm>
#include <array>
#include <limits>

#include "impacts/impacts.h"
#include "motion/free_rotation.h"

namespace genphys {
namespace {

// m: two that meet somebody at once are as near to it but for this.
constexpr double kRounding = 1e-9;
// Of the gap between two: by less than this they miss each other if they come together as it seemed.
constexpr double kStraight = 0.1;
// rad: between faces that are one.
constexpr double kLevel = 1e-6;

// Whether one of `others` hits one of the two of `blow` in the same direction.
bool IsLevelWithAny(const Blow& blow, std::span<const Blow> others) {
  return std::ranges::any_of(others, [&](const Blow& other) {
    const bool is_on_same = other.body_a == blow.body_a || other.body_b == blow.body_b;
    return is_on_same && other.normal.cross(blow.normal).squaredNorm() < kLevel * kLevel;
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
  std::vector<Blow> first;
  for (size_t i = 0; i < blows_.size(); ++i) {
    if (blow_pairs_[i]->is_apart) continue;
    first.push_back(blows_[i]);
    Ask(first.back(), blow_pairs_[i]->pair);
  }
  std::vector<StruckBody> after = bodies_;
  Restitute(first, after, ties_);
  for (Candidate& candidate : candidates_) candidate.is_apart = candidate.is_apart && !Reaches(candidate, after);
  size_t kept = 0;
  for (size_t i = 0; i < blows_.size(); ++i) {
    // What lands flat on several does so as on one.
    if (blow_pairs_[i]->is_apart && !IsLevelWithAny(blows_[i], first)) continue;
    blows_[kept] = blows_[i];
    blow_pairs_[kept++] = blow_pairs_[i];
  }
  blows_.resize(kept);
  blow_pairs_.resize(kept);
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
// between two that lie flat on each other, not past an edge.
bool Impacts::Reaches(const Candidate& candidate, std::span<const StruckBody> after) const {
  const ContactPair& pair = candidate.pair;
  const auto placed = [&](EntityRow entity, GeometryRow geometry, double time) {
    const auto i = static_cast<size_t>(world_.struck_index[entity]);
    Pose pose = struck_[i].motion.PoseBefore(struck_[i].time);
    const Quaternion turn = Turned(Quaternion::Identity(), after[i].angular_velocity, time);
    pose.position = after[i].center + time * after[i].linear_velocity + turn * (pose.position - after[i].center);
    pose.orientation = turn * pose.orientation;
    return ToPlacement(pose.Transform(GeometryAt(geometry).pose_in_entity));
  };
  const auto meet = [&](double time, Manifold& manifold) {
    FindContacts(GeometryAt(pair.geometry_a).shape, placed(pair.entity_a, pair.geometry_a, time),
                 GeometryAt(pair.geometry_b).shape, placed(pair.entity_b, pair.geometry_b, time),
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
  if (!(way < kSameTime * step_size_ * closing)) return false;
  return GapOf(meet(way / closing, manifold)) - candidate.nearest < kStraight * way;
}

}  // namespace genphys

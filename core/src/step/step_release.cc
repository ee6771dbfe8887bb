// What contacts and joints still owe to the velocities: paid to who is let go of, begun anew, or dropped after blows.
#include <algorithm>
#include <utility>
#include <vector>

#include "pairs/contact_points.h"
#include "pairs/disjoint_sets.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// Of the forces by which those that hang together are held: what is left of their sum beyond that is of somebody else.
constexpr double kOfOthers = 1e-3;
}  // namespace

bool StepRun::Holds(const ContactPair& pair) const {
  if (pair.is_sensor) return false;
  const auto first = world_.contacts_.points.begin() + pair.first_point;
  return std::any_of(first, first + pair.point_count,
                     [](const ContactPoint& point) { return point.depth > -kReleaseGap; });
}

// Whoever nothing touches or holds any more is paid what contacts and joints owed; it is shown already.
void StepRun::PayReleased(const RowMarks* among) {
  RowMarks& held = scratch_.held;
  held.Clear();
  for (const ContactPair& pair : world_.contacts_.pairs) {
    if (!Holds(pair)) continue;
    held.Mark(pair.entity_a);
    held.Mark(pair.entity_b);
  }
  const auto is_released = [&](EntityRow row) {
    return (among == nullptr || (*among)[row]) && !held[row] && !scratch_.jointed[row] &&
           !world_.layer_.half_steps[Index(row)].restarts;
  };
  RowMarks& released = scratch_.paid;
  released.Clear();
  for (const Mover& mover : movers_) released.Set(mover.row, is_released(mover.row));
  PayAcross(released);
  for (const Mover& mover : movers_) {
    HalfStep& half = world_.layer_.half_steps[Index(mover.row)];
    if (!is_released(mover.row)) continue;
    half.velocity += half.held_velocity;
    half.momentum += half.held_momentum;
    half.held_velocity.setZero();
    half.held_momentum.setZero();
    half.held_torque.setZero();
  }
}

// Who is paid all that contacts owed has it from those contacts: whom they pressed it against, and who goes on as
// before, gets his part of them as well, or momentum would come or go.
void StepRun::PayAcross(const RowMarks& paid) {
  for (const ContactPair& pair : world_.solved_.pairs) {
    if (pair.is_sensor || pair.owed == 0 || paid[pair.entity_a] == paid[pair.entity_b]) continue;
    if (!IsMoved(pair.entity_a) || !IsMoved(pair.entity_b)) continue;
    // Joints would have to pass it on.
    if (scratch_.jointed[pair.entity_a] || scratch_.jointed[pair.entity_b]) continue;
    const bool is_a = paid[pair.entity_b];
    const EntityRow row = is_a ? pair.entity_a : pair.entity_b;
    const auto is_owed = [&](EntityRow of) {
      const HalfStep& half = world_.layer_.half_steps[Index(of)];
      return !half.is_woken && (!half.held_velocity.isZero(0) || !half.held_momentum.isZero(0));
    };
    // One that was let go of before took this part with it.
    if (is_owed(pair.entity_a) && is_owed(pair.entity_b)) PayPart(pair, row);
  }
}

// But for what is along gravity: that bears a weight, which the ground or those below have to bear as well, and
// who is paid a part of all that without the others is thrown about until the next solve. Along that nobody asks for
// momentum, for it goes into the ground.
void StepRun::PayPart(const ContactPair& pair, EntityRow row) {
  HalfStep& half = world_.layer_.half_steps[Index(row)];
  const double mass = world_.scene_.entities[Index(row)]->mass.mass;
  const Vector3 center = CenterOf(row), pull = world_.scene_.world.gravity.stableNormalized();
  const double part = row == pair.entity_a ? -pair.owed : pair.owed;
  for (const ContactPoint& point : PointsOf(world_.solved_, pair)) {
    const Vector3 whole = part * (point.normal_impulse * point.normal + point.friction_impulse);
    const Vector3 impulse = whole - whole.dot(pull) * pull, twist = (point.position - center).cross(impulse);
    half.velocity += impulse / mass;
    half.held_velocity -= impulse / mass;
    half.momentum += twist;
    half.held_momentum -= twist;
  }
}

// Calls join(a, b) with the numbers of two that a contact which `holds` or a joint holds together: a mover's place in
// movers_ and one, or zero for whom nothing moves.
void StepRun::VisitHeldTogether(absl::FunctionRef<bool(const ContactPair&)> holds,
                                absl::FunctionRef<void(uint32_t, uint32_t)> join) {
  RowValues<int>& numbers = scratch_.struck_index;
  for (size_t i = 0; i < movers_.size(); ++i) numbers[movers_[i].row] = static_cast<int>(i + 1);
  const auto number = [&](EntityRow row) {
    const int found = row == kWorldRow ? -1 : std::as_const(numbers)[row];
    return static_cast<uint32_t>(std::max(found, 0));
  };
  for (const ContactPair& pair : world_.contacts_.pairs) {
    if (holds(pair)) join(number(pair.entity_a), number(pair.entity_b));
  }
  for (const Mover& mover : movers_) {
    if (!scratch_.jointed[mover.row]) continue;
    for (const uint32_t slot : world_.joint_index_.Of(mover.row)) {
      const JointDesc& joint = world_.scene_.joints[slot]->desc;
      join(number(RowOf(joint.entity_a)), number(RowOf(joint.entity_b)));
    }
  }
  numbers.Clear();
}

// Of movers by their numbers, not through what nothing moves.
DisjointSets StepRun::HangTogether() {
  DisjointSets sets(movers_.size() + 1);
  const auto holds = [&](const ContactPair& pair) { return Holds(pair); };
  VisitHeldTogether(holds, [&](uint32_t a, uint32_t b) {
    if (a > 0 && b > 0) sets.Join(a, b);
  });
  return sets;
}

// Bodies that hang together and lost what held them all, as a pile does whose floor is gone, still touch each other,
// but what the floor owed them is not given by any solve to come.
void StepRun::RestartFallen() {
  // Who was let go of by what moved was so by how that moved. Joints that are undone begin anew by themselves.
  if (world_.let_go_.empty()) return;
  DisjointSets sets(movers_.size() + 1);
  const auto holds = [&](const ContactPair& pair) { return Holds(pair); };
  VisitHeldTogether(holds, [&](uint32_t a, uint32_t b) { sets.Join(a, b); });
  struct Held {
    int members = 0;
    bool has_lost = false;
    Vector3 sum = Vector3::Zero();  // N
    double size = 0;                // N
  };
  std::vector<Held> groups(movers_.size() + 1);
  for (size_t i = 0; i < movers_.size(); ++i) {
    const uint32_t root = sets.Find(static_cast<uint32_t>(i + 1));
    const HalfStep& half = world_.layer_.half_steps[Index(movers_[i].row)];
    ++groups[root].members;
    groups[root].has_lost |= world_.let_go_[movers_[i].row];
    if (root == 0 || half.restarts) continue;
    const Vector3 force = world_.scene_.entities[Index(movers_[i].row)]->mass.mass * half.held_rate;
    groups[root].sum += force;
    groups[root].size += force.norm();
  }
  for (size_t i = 0; i < movers_.size(); ++i) {
    const uint32_t root = sets.Find(static_cast<uint32_t>(i + 1));
    const Held& group = groups[root];
    const bool has_lost = group.has_lost && group.sum.norm() > kOfOthers * group.size;
    if (root == 0 || group.members == 1 || !has_lost) continue;
    world_.layer_.half_steps[Index(movers_[i].row)].Restart();
  }
}

// A lift that starts or stops at once holds what it carries by another force from then on.
void StepRun::RestartCarried() {
  std::vector<EntityRow> carried;
  for (const ContactPair& pair : world_.contacts_.pairs) {
    for (const auto& [leader, other] :
         {std::pair(pair.entity_a, pair.entity_b), std::pair(pair.entity_b, pair.entity_a)}) {
      if (IsDynamic(leader) || !courses_.IsLedOtherwise(leader) || !Holds(pair)) continue;
      carried.push_back(other);
    }
  }
  if (carried.empty()) return;
  DisjointSets sets = HangTogether();
  RowMarks& marks = scratch_.held;
  marks.Clear();
  for (const EntityRow row : carried) marks.Mark(row);
  std::vector<uint8_t> restarts(movers_.size() + 1);
  const auto root_of = [&](size_t mover) { return sets.Find(static_cast<uint32_t>(mover + 1)); };
  for (size_t i = 0; i < movers_.size(); ++i) {
    if (marks[movers_[i].row]) restarts[root_of(i)] = true;
  }
  for (size_t i = 0; i < movers_.size(); ++i) {
    if (restarts[root_of(i)]) world_.layer_.half_steps[Index(movers_[i].row)].RestartNowAndThen();
  }
}

// What hangs together begins anew together. A solve acts on each from the middle of its last substep or, if that begins
// anew, from the boundary on: where one did and its neighbour did not, this one's weight would press on the other for
// twice as long as that rubs, and what the two give each other would be paid to one of them alone.
void StepRun::RestartTogether() {
  const auto begins = [](const Mover& mover) { return mover.beginning != Beginning::kNone; };
  if (std::ranges::none_of(movers_, begins)) return;
  DisjointSets sets = HangTogether();
  struct Group {
    Beginning beginning = Beginning::kNone;
    bool pauses = false;
  };
  std::vector<Group> groups(movers_.size() + 1);
  const auto group_of = [&](size_t mover) -> Group& { return groups[sets.Find(static_cast<uint32_t>(mover + 1))]; };
  for (size_t i = 0; i < movers_.size(); ++i) {
    Group& group = group_of(i);
    group.beginning = std::max(group.beginning, movers_[i].beginning);
    const HalfStep& half = world_.layer_.half_steps[Index(movers_[i].row)];
    group.pauses |= !half.restarts && half.Pauses();
  }
  for (size_t i = 0; i < movers_.size(); ++i) {
    const auto& [beginning, pauses] = group_of(i);
    // Where one of them may not, none does: what is pushed otherwise while it goes on as it did is exact as well.
    const bool restarts = beginning == Beginning::kMust || (beginning != Beginning::kNone && !pauses);
    if (restarts) world_.layer_.half_steps[Index(movers_[i].row)].Restart();
  }
}

}  // namespace genphys

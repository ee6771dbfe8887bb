// Who is let go of: what contacts and joints still owe to the velocities is paid, or begun anew.
#include <algorithm>
#include <utility>
#include <vector>

#include "disjoint_sets.h"
#include "step_run.h"

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
void StepRun::PayReleased() {
  RowMarks& held = scratch_.held;
  held.Clear();
  for (const ContactPair& pair : world_.contacts_.pairs) {
    if (!Holds(pair)) continue;
    held.Mark(pair.entity_a);
    held.Mark(pair.entity_b);
  }
  for (const Mover& mover : movers_) {
    HalfStep& half = world_.layer_.half_steps[Index(mover.row)];
    if (held[mover.row] || scratch_.jointed[mover.row] || half.restarts) continue;
    half.velocity += half.held_velocity;
    half.momentum += half.held_momentum;
    half.held_velocity.setZero();
    half.held_momentum.setZero();
  }
}

// Bodies that hang together and lost what held them all, as a pile does whose floor is gone, still touch each other,
// but what the floor owed them is not given by any solve to come.
void StepRun::RestartFallen() {
  // Joints that are undone begin anew by themselves.
  if (!is_rearranged_ && world_.contacts_.pairs.empty() && world_.layer_.touching.empty()) return;
  RowValues<int>& numbers = scratch_.struck_index;
  for (size_t i = 0; i < movers_.size(); ++i) numbers[movers_[i].row] = static_cast<int>(i + 1);
  const auto number = [&](EntityRow row) {
    const int found = row == kWorldRow ? -1 : std::as_const(numbers)[row];
    return static_cast<uint32_t>(std::max(found, 0));  // zero: nothing that moves, or what nothing moves
  };
  DisjointSets sets(movers_.size() + 1);
  for (const ContactPair& pair : world_.contacts_.pairs) {
    if (Holds(pair)) sets.Join(number(pair.entity_a), number(pair.entity_b));
  }
  for (const Mover& mover : movers_) {
    if (!scratch_.jointed[mover.row]) continue;
    for (const uint32_t slot : world_.joint_index_.Of(mover.row)) {
      const JointDesc& joint = world_.scene_.joints[slot]->desc;
      sets.Join(number(RowOf(joint.entity_a)), number(RowOf(joint.entity_b)));
    }
  }
  numbers.Clear();
  struct Held {
    int members = 0;
    Vector3 sum = Vector3::Zero();  // N
    double size = 0;                // N
  };
  std::vector<Held> groups(movers_.size() + 1);
  for (size_t i = 0; i < movers_.size(); ++i) {
    const uint32_t root = sets.Find(static_cast<uint32_t>(i + 1));
    const HalfStep& half = world_.layer_.half_steps[Index(movers_[i].row)];
    ++groups[root].members;
    if (root == 0 || half.restarts) continue;
    const Vector3 force = world_.scene_.entities[Index(movers_[i].row)]->mass.mass * half.held_rate;
    groups[root].sum += force;
    groups[root].size += force.norm();
  }
  for (size_t i = 0; i < movers_.size(); ++i) {
    const uint32_t root = sets.Find(static_cast<uint32_t>(i + 1));
    const Held& group = groups[root];
    if (root == 0 || group.members == 1 || group.sum.norm() <= kOfOthers * group.size) continue;
    world_.layer_.half_steps[Index(movers_[i].row)].Restart();
  }
}

}  // namespace genphys

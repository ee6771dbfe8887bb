#include "impacts/ties.h"

#include <algorithm>
#include <numeric>
#include <type_traits>
#include <utility>

#include "joints/row_rate.h"

namespace genphys {
namespace {

Velocities VelocitiesOf(const JointBody& body) { return {body.linear_velocity, body.angular_velocity}; }

void Rest(JointBody& body) {
  body.linear_velocity.setZero();
  body.angular_velocity.setZero();
}

}  // namespace

// A copy would leave the solver with the rows of another group.
static_assert(std::is_nothrow_move_constructible_v<RowSolver>);

bool Ties::Add(std::span<const uint32_t> members, std::vector<JointBody> bodies, std::vector<JointRow> rows,
               std::vector<uint32_t> slots) {
  Group group{.members = {members.begin(), members.end()},
              .bodies = std::move(bodies),
              .rows = std::move(rows),
              .slots = std::move(slots),
              .lacking = {},
              .is_driven = false,
              .solver = {}};
  group.is_driven = std::ranges::any_of(group.bodies, [](const JointBody& body) {
    return !body.is_movable() && !(body.linear_velocity.isZero(0) && body.angular_velocity.isZero(0));
  });
  std::vector<JointBody> at_rest = group.bodies;
  for (JointBody& body : at_rest) Rest(body);
  for (JointRow& row : group.rows) row.target = 0;
  std::vector<uint32_t> mine(group.rows.size()), body_of(group.bodies.size());
  std::iota(mine.begin(), mine.end(), 0);
  std::iota(body_of.begin(), body_of.end(), 0);
  const auto is_solved = [&] {
    return group.solver.Solve(0, group.rows, mine, body_of, at_rest) && !group.solver.is_swept();
  };
  if (!group.rows.empty() && !is_solved()) return false;
  Hold(group, group.lacking);
  const uint32_t last = *std::ranges::max_element(members);
  if (last >= group_of_.size()) {
    group_of_.resize(last + 1, kFree);
    place_of_.resize(last + 1);
  }
  for (uint32_t i = 0; i < members.size(); ++i) {
    group_of_[members[i]] = static_cast<uint32_t>(groups_.size());
    place_of_[members[i]] = i + 1;
  }
  // The solver goes on with the rows where they are, which a move of their vector does not change.
  groups_.push_back(std::move(group));
  return true;
}

void Ties::Pass(std::span<const Push> pushes, std::vector<Change>& changes) {
  uint32_t last = kFree;
  for (const Push& push : pushes) {
    const uint32_t group = GroupOf(push.body);
    if (group != kFree && group != last) Pass(groups_[group], pushes, changes);
    last = group;
  }
}

void Ties::Pass(Group& group, std::span<const Push> pushes, std::vector<Change>& changes) const {
  const auto group_number = static_cast<uint32_t>(&group - groups_.data());
  for (const Push& push : pushes) {
    if (GroupOf(push.body) != group_number) continue;
    JointBody& body = group.bodies[place_of_[push.body]];
    body.linear_velocity += body.inverse_mass * push.linear;
    body.angular_velocity += body.inverse_tensor * push.angular;
  }
  const size_t first = changes.size();
  for (size_t i = 0; i < group.members.size(); ++i) {
    const JointBody& body = group.bodies[i + 1];
    changes.push_back({group.members[i], body.linear_velocity, body.angular_velocity});
  }
  std::vector<Change> held;
  Hold(group, held);
  for (size_t i = 0; i < held.size(); ++i) {
    changes[first + i].linear += held[i].linear;
    changes[first + i].angular += held[i].angular;
  }
}

void Ties::Hold(Group& group, std::vector<Change>& changes) {
  for (JointRow& row : group.rows) {
    const auto side = [&](EntityRow of) -> const JointBody& { return group.bodies[of == kWorldRow ? 0 : Index(of)]; };
    const JointBody &a = side(row.a), &b = side(row.b);
    row.target = -RateOf(row, a, VelocitiesOf(a), b, VelocitiesOf(b));
  }
  for (JointBody& body : group.bodies) Rest(body);
  if (group.rows.empty() || !group.solver.SolveAgain(0, group.bodies)) return;
  for (size_t i = 0; i < group.members.size(); ++i) {
    JointBody& body = group.bodies[i + 1];
    changes.push_back({group.members[i], body.linear_velocity, body.angular_velocity});
    Rest(body);
  }
}

}  // namespace genphys

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "genphys/joint_row.h"
#include "genphys/math.h"
#include "joints/joint_body.h"
#include "joints/row_solver.h"

namespace genphys {

/// Which of the bodies that are hit at one moment joints hold together. A blow takes no time, and joints pass it on at
/// once: who hits the end of a chain feels all of it, and whatever of the chain hangs on the world.
class Ties {
 public:
  /// An impulse on a body, N*s, and about its centre of mass, N*m*s.
  struct Push {
    uint32_t body = 0;
    Vector3 linear = Vector3::Zero();
    Vector3 angular = Vector3::Zero();
  };
  /// What pushes change of the velocity of a body, m/s and rad/s.
  struct Change {
    uint32_t body = 0;
    Vector3 linear = Vector3::Zero();
    Vector3 angular = Vector3::Zero();
  };

  /// Ties `members`, which are not tied yet, by `rows`, of which the first are of the joints `slots`. `bodies` are the
  /// world, then the members in their order, then what nothing moves, and have their places among them as rows, which
  /// the sides of `rows` are. Without rows nothing holds them. False, and nothing done: the rows contradict each other,
  /// or the numbers do not suffice.
  bool Add(std::span<const uint32_t> members, std::vector<JointBody> bodies, std::vector<JointRow> rows,
           std::vector<uint32_t> slots);

  /// Nobody is tied.
  bool empty() const { return groups_.empty(); }

  /// All that are tied to this body, and itself; none if nothing is.
  std::span<const uint32_t> With(uint32_t body) const {
    const uint32_t group = GroupOf(body);
    return group == kFree ? std::span<const uint32_t>() : groups_[group].members;
  }

  /// Whether the body is tied to something that nothing moves and that moves by itself.
  bool IsDriven(uint32_t body) const {
    const uint32_t group = GroupOf(body);
    return group != kFree && groups_[group].is_driven;
  }

  /// Calls visit(change) for each tied body with what its velocity, that of the `bodies` of Add(), lacks for it to move
  /// as joints let it.
  template <typename Visit>
  void VisitLacking(Visit&& visit) const {
    for (const Group& group : groups_) {
      for (const Change& change : group.lacking) visit(change);
    }
  }

  /// Appends how all that are tied to `pushes`, of tied bodies, move by them.
  void Pass(std::span<const Push> pushes, std::vector<Change>& changes);

  /// Calls visit(slot, row) for each row of all joints, with the impulse that `pushes` leave it to bear.
  template <typename Visit>
  void VisitBorne(std::span<const Push> pushes, Visit&& visit) {
    std::vector<Change> changes;
    for (Group& group : groups_) {
      Pass(group, pushes, changes);
      for (size_t i = 0; i < group.slots.size(); ++i) visit(group.slots[i], group.rows[i]);
    }
  }

 private:
  static constexpr uint32_t kFree = ~uint32_t{0};

  struct Group {
    std::vector<uint32_t> members;
    std::vector<JointBody> bodies;  // at rest between two calls
    std::vector<JointRow> rows;
    std::vector<uint32_t> slots;  // of rows of joints, which come first
    std::vector<Change> lacking;
    bool is_driven = false;
    RowSolver solver;
  };

  // Appends what joints add to the motion of the group's bodies, and puts them at rest. What no number can hold they
  // let go.
  static void Hold(Group& group, std::vector<Change>& changes);
  uint32_t GroupOf(uint32_t body) const { return body < group_of_.size() ? group_of_[body] : kFree; }
  // Those of `pushes` that are on the group.
  void Pass(Group& group, std::span<const Push> pushes, std::vector<Change>& changes) const;

  std::vector<Group> groups_;
  std::vector<uint32_t> group_of_;  // by body
  std::vector<uint32_t> place_of_;  // in the bodies of its group
};

}  // namespace genphys

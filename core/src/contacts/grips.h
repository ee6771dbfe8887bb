#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "genphys/contact.h"
#include "genphys/contact_memory.h"
#include "genphys/contact_sweeps.h"

namespace genphys {

/// A pair of geometries whose contacts are to be solved.
struct AddedPair {
  uint32_t a;  // numbers of bodies
  uint32_t b;
  const ContactPair* pair;
  std::span<ContactPoint> points;
  std::span<PointImpulse> impulses;  // to start from
};

/// How friction held two bodies together in the last solve.
struct Grip {
  bool is_on_a_line = false;
  bool is_on_ground = false;         // of few, beside each other, on what cannot be moved
  Vector3 braked = Vector3::Zero();  // N*s on b, by which friction starts, of all points together
  double load = 0;                   // N*s, how much that is
  double count = 1;                  // of the points
  bool bears = false;                // that is a load
  bool may_share = false;            // each half of the points, taken in turns, could hold twice that alone
};

/// The grips of pairs. How points share a load is left to chance, so that all of a pair count together; and among few
/// points all by which one body lies on another one, or on what cannot be moved, with whatever geometries they do:
/// pairs that held against each other across the load would each hold along another direction than that, and all of
/// them together more than friction can.
class Grips {
 public:
  /// `all_at_once`: so will it be solved. `are_few`: all of them have but few points.
  void Find(std::span<const AddedPair> pairs, std::span<const SweptBody> bodies, bool all_at_once, bool are_few);

  Grip Of(size_t pair) const;
  /// Whether nothing else is to be solved than where two lie on each other.
  bool AreAllOne() const { return groups_.size() == 1; }

 private:
  using Sides = std::pair<uint32_t, uint32_t>;
  struct HashSides {
    size_t operator()(const Sides& sides) const {
      return std::hash<uint64_t>()(uint64_t{sides.first} << 32 | sides.second);
    }
  };

  struct Group {
    Vector3 normal;  // on `b`
    Vector3 braked = Vector3::Zero();
    double most[2] = {};  // N*s, that friction could have held at each half of the points
    size_t count = 0;
    size_t first = 0;  // of its pairs
    size_t last = 0;
    size_t next_group = kNone;  // of the same two, against other surfaces
  };
  struct Member {
    size_t group;
    double sign;          // of b, as the group sees it
    size_t next = kNone;  // of the group
  };
  static constexpr size_t kNone = ~size_t{0};

  void ForgetGroups();
  size_t GroupOf(const AddedPair& pair, const Sides& sides, const Vector3& normal, bool is_of_few);
  void Add(const AddedPair& pair, bool is_of_few);
  bool IsOnALine(std::span<const AddedPair> pairs, const Group& group);

  std::vector<Group> groups_;
  std::vector<Member> members_;                            // by pair
  std::vector<Grip> grips_;                                // by group
  std::unordered_map<Sides, size_t, HashSides> group_of_;  // the first of each two
  std::vector<Vector3> places_;                            // scratch
};

}  // namespace genphys

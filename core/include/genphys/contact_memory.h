#pragma once
#include <compare>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "genphys/contact.h"
#include "genphys/ids.h"
#include "genphys/narrow_phase.h"
#include "genphys/placement.h"
#include "genphys/resting_pairs.h"

namespace genphys {

/// What a contact point passed on to b, N*s, world.
struct PointImpulse {
  double normal = 0;                   // along the normal
  Vector3 friction = Vector3::Zero();  // across it
  Vector3 torque = Vector3::Zero();    // N*m*s, of what resists rolling and spinning
};

/// The impulses by which an engine recognises contacts from solve to solve: all that it needs to remember.
class ContactMemory {
 public:
  /// Two geometries, in canonical order as in ContactBuffer.
  struct Key {
    EntityId a, b;
    uint32_t geometry_a = 0, geometry_b = 0;  // ids
    auto operator<=>(const Key&) const = default;
  };

  /// One for each point of a pair: few, but for meshes.
  template <typename T>
  using PerPoint = absl::InlinedVector<T, Manifold::kPointsPerNormal>;

  /// What a solve left of a pair, for the next one to start from.
  struct Pair {
    Key key;
    double interval = 0;       // s, for which the impulses acted
    PerPoint<Vector3> places;  // of the points in the frame of one side
    PerPoint<PointImpulse> impulses;
    // What the solve before passed on to b in all, also where none of its points is left, scaled to the interval.
    PointImpulse before;
  };

  /// What becomes of an entity in the next solve.
  enum class Motion : uint8_t {
    kMoving,
    kResting,  // until it is woken
    kNone,     // ever
    kGone,
  };

  /// Starts a new list of pairs; those of the last one, and those of bodies that were woken since, are recognised.
  /// `motion_of(id)` tells the Motion of an entity; where nothing of a pair moves, it is kept until something does.
  template <typename MotionOf>
  void Begin(MotionOf motion_of) {
    if (std::exchange(has_slept_, false)) {
      for (const Pair& pair : pairs_) KeepResting(pair, motion_of(pair.key.a), motion_of(pair.key.b));
    }
    BeginList();
  }

  /// Adds the next pair, in canonical order, with impulses from where its points were before, for a solve that acts for
  /// `interval` s and leaves those alone that are ahead. In `frame` its points stand still while it slides.
  void Add(const Key& key, const Placement& frame, double interval, std::span<const ContactPoint> points);

  /// Adds the next pair with the impulses of another engine, which had other points `solved`: all that held the pair is
  /// shared out to those that it has here.
  void AddSolved(const Key& key, const Placement& frame, double interval, std::span<const ContactPoint> points,
                 std::span<const ContactPoint> solved);

  /// Tells that a body moves again, or does not until it is told again.
  void SetActive(EntityId id, bool active);

  /// Forgets what rests by a body that was removed.
  void Remove(EntityId id);

  /// Appends all that the next solve depends on.
  void Save(std::string& bytes) const;

  /// In the order in which they were added.
  std::span<Pair> pairs() { return pairs_; }

 private:
  void KeepResting(const Pair& pair, Motion a, Motion b);
  void BeginList();
  Pair& Append(const Key& key, const Placement& frame, double interval, std::span<const ContactPoint> points);

  std::vector<Pair> pairs_;
  std::vector<Pair> before_;
  RestingPairs<Pair, uint64_t> resting_;  // by packed id
  std::vector<EntityId> woken_;
  bool has_slept_ = false;
  size_t next_before_ = 0;
};

}  // namespace genphys

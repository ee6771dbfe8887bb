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
  /// Two geometries, which follow each other as in ContactBuffer.
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
    double load = 0;  // N*s along the normal in the solve before, of all its points then, scaled to the interval
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
    PutAway(motion_of);
    // Some were woken and fell asleep again.
    std::erase_if(woken_, [&](EntityId id) { return motion_of(id) != Motion::kMoving; });
    BeginList();
  }

  /// Takes pairs of which nothing moves any more out of the list: the next one need not look at them. Begin() does so
  /// otherwise.
  template <typename MotionOf>
  void PutAway(MotionOf motion_of) {
    ForgetRemoved();
    if (!std::exchange(has_slept_, false)) return;
    before_.clear();
    const auto is_kept = [&](Pair& pair) { return KeepResting(pair, motion_of(pair.key.a), motion_of(pair.key.b)); };
    size_t left = 0;
    for (size_t i = 0; i < pairs_.size(); ++i) {
      if (is_kept(pairs_[i])) continue;
      if (left < i) pairs_[left] = std::move(pairs_[i]);
      ++left;
    }
    pairs_.resize(left);
  }

  /// Adds the next pair, in canonical order, with impulses from where its points were before, for a solve that acts for
  /// `interval` s and leaves those alone that are ahead. In `frame` its points stand still while it slides.
  void Add(const Key& key, const Placement& frame, double interval, std::span<const ContactPoint> points);

  /// All pairs of a solve at once; identify(pair) tells the Key and the frame of one.
  template <typename MotionOf, typename Identify>
  void Recognise(const ContactBuffer& contacts, MotionOf motion_of, Identify identify) {
    Begin(motion_of);
    for (const ContactPair& pair : contacts.pairs) {
      const auto [key, frame] = identify(pair);
      Add(key, frame, pair.interval, std::span(contacts.points).subspan(pair.first_point, pair.point_count));
    }
  }

  /// Before the first list: what another engine solved last; find(pair, points) finds the points that it has here.
  template <typename Identify, typename Find>
  void Recall(const ContactBuffer& solved, Identify identify, Find find) {
    std::vector<ContactPoint> own;
    for (const ContactPair& pair : solved.pairs) {
      if (pair.is_sensor) continue;
      own.clear();
      find(pair, own);
      const auto [key, frame] = identify(pair);
      AddSolved(key, frame, pair.interval, own, std::span(solved.points).subspan(pair.first_point, pair.point_count));
    }
  }

  /// Adds the next pair with the impulses of another engine, which had other points `solved`: all that held the pair is
  /// shared out to those that it has here.
  void AddSolved(const Key& key, const Placement& frame, double interval, std::span<const ContactPoint> points,
                 std::span<const ContactPoint> solved);

  /// A memory of what was before the last list: loads alone, and of no point.
  ContactMemory OfBefore() const;

  /// Tells that a body moves again, or does not until it is told again.
  void SetActive(EntityId id, bool active);

  /// Forgets a body that was removed. Another one may have its id from now on.
  void Remove(EntityId id);

  /// Appends all that the next solve depends on.
  void Save(std::string& bytes) const;

  /// In the order in which they were added.
  std::span<Pair> pairs() { return pairs_; }

 private:
  void ForgetRemoved();
  // Unless something of it moves. Returns whether it did, and the pair is empty then.
  bool KeepResting(Pair& pair, Motion a, Motion b);
  void BeginList();
  Pair& Append(const Key& key, const Placement& frame, double interval, std::span<const ContactPoint> points);

  std::vector<Pair> pairs_;
  std::vector<Pair> before_;
  RestingPairs<Pair, uint64_t> resting_;  // by packed id
  std::vector<EntityId> woken_;           // since the last list
  std::vector<EntityId> removed_;         // the same
  bool has_slept_ = false;
  size_t next_before_ = 0;
};

}  // namespace genphys

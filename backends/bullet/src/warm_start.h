#pragma once
#include <span>
#include <string>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "body.h"
#include "contacts.h"
#include "genphys/contact.h"
#include "genphys/resting_pairs.h"

namespace genphys::bullet_backend {

/// Two geometries that meet.
struct MeetingPair {
  PlacedGeometry* a = nullptr;
  PlacedGeometry* b = nullptr;
};

/// What a contact point passed on to b, N*s, world.
struct PointImpulse {
  double normal = 0;                   // along the normal
  Vector3 friction = Vector3::Zero();  // across it
  Vector3 torque = Vector3::Zero();    // N*m*s, of what resists rolling and spinning
};

/// One for each point of a pair: few, but for meshes.
template <typename T>
using PerPoint = absl::InlinedVector<T, Manifold::kPointsPerNormal>;

/// What the last solve left of a pair, for the next one to start from.
struct PairMemory {
  PlacedGeometry* a = nullptr;
  PlacedGeometry* b = nullptr;
  double interval = 0;       // s, for which the impulses acted
  PerPoint<Vector3> places;  // of the points in the frame of the side that can move
  PerPoint<PointImpulse> impulses;
};

/// The impulses by which contacts are recognised from step to step: all that this adapter remembers.
class WarmStart {
 public:
  /// Starts a new list of pairs; those of the last one, and those of bodies that were woken since, are recognised.
  void Begin();

  /// Adds the next pair, in canonical order, with impulses from where its points were before, for a solve that acts for
  /// `interval` s and leaves those alone that are ahead.
  void Add(const MeetingPair& pair, double interval, std::span<const ContactPoint> points);

  /// Ends the list. What was not met again is forgotten, unless both sides rest and nobody has looked.
  void End();

  /// Tells that a body moves again.
  void Wake(const Body* body) { woken_.push_back(body); }

  /// Forgets the pairs of bodies that were removed. They must still be there.
  void ForgetRemoved();
  size_t size() const { return pairs_.size() + resting_.size(); }

  /// Appends all that the next solve depends on.
  void Save(std::string& bytes) const;

  std::span<PairMemory> pairs() { return pairs_; }

 private:
  void PassOver(const PairMemory& memory);

  std::vector<PairMemory> pairs_;
  std::vector<PairMemory> before_;
  RestingPairs<PairMemory, const Body*> resting_;
  std::vector<const Body*> woken_;
  size_t next_before_ = 0;
};

}  // namespace genphys::bullet_backend

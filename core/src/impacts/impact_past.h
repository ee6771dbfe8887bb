#pragma once
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "genphys/contact.h"
#include "genphys/entity.h"
#include "genphys/narrow_phase.h"
#include "impacts/impact_motion.h"
#include "impacts/impact_speed.h"
#include "impacts/impact_world.h"
#include "pairs/ordered_search.h"

namespace genphys {

/// How those that collide came to where they are at the end of the substep, and what held them on their way. Times are
/// seconds before that end.
class ImpactPast {
 public:
  ImpactPast(const ImpactWorld& world, double step_size)
      : world_(world), speed_(world, step_size), step_size_(step_size) {}

  /// From now on these are known to be the ways since each was hit, by row.
  void Follow(std::span<const FlownWay> ways) { ways_ = ways; }

  /// These, ascending, turn about where they are pressed against what nothing moves.
  void SetTipping(std::vector<EntityRow> rows) { tipping_ = std::move(rows); }

  bool IsMovable(EntityRow row) const;
  /// Nobody knows yet what holds it.
  bool IsWoken(EntityRow row) const { return world_.layer.half_steps[Index(row)].is_woken; }
  /// In this substep.
  bool IsHit(EntityRow row) const;
  /// It is pressed against what nothing moves, and against nobody else.
  bool StandsOnGround(EntityRow row) const;
  /// How long ago both were last hit, or the substep began: before that they did not go as they do now.
  double FreeSince(const ContactPair& pair) const;
  /// When the step began.
  bool WereTouching(const EntityPair& entities) const;
  /// Against each other, in the last solve, or in the last one before they slept if that was until now. Not who only
  /// touch, whom rounding and errors that are made up for press a little: by no more than is no impact either.
  bool WerePressed(const EntityPair& entities) const;
  /// The same two surfaces, and about as they touch there now.
  bool WerePressedSo(const ContactPair& pair, const Vector3& normal) const;
  /// The same, and no farther than `distance` (m) from there.
  bool WerePressedNear(const ContactPair& pair, const Vector3& position, double distance) const;
  /// The last solve pressed it against nobody whom something can move.
  bool PressesNobody(EntityRow row) const;

  /// The way of one that was hit in this substep and put elsewhere, or null.
  const FlownWay* WayFromBlow(EntityRow row) const;
  /// What sped up a body on the ground, m/s^2.
  Vector3 CourseOf(EntityRow row) const;
  /// Of that, what is no matter of the ground, which may hold it otherwise after the next blow.
  Vector3 PushOf(EntityRow row) const;
  /// What turned it about its centre of mass, N*m.
  Vector3 TwistOf(EntityRow row) const;
  /// What pulls at it, in flight or on the ground, beyond what holds it, m/s^2.
  Vector3 PullOn(EntityRow row) const;
  ImpactMotion MotionOf(EntityRow row) const;

  const Geometry& GeometryAt(GeometryRow row) const;
  /// Where two meet if a is where it was `time_a` ago and b where it was `time_b` ago, with points no farther apart
  /// than `gap` (m).
  void FindMeeting(const ContactPair& pair, double time_a, double time_b, double gap, Manifold& manifold) const;
  /// The same of bodies that move as `a` and `b`.
  void FindMeeting(const ContactPair& pair, const ImpactMotion& a, double time_a, const ImpactMotion& b, double time_b,
                   double gap, Manifold& manifold) const;

 private:
  // m/s, by which an impulse (N*s) would move the two apart, were they alone.
  double Apart(const EntityPair& entities, double impulse) const;
  // Calls found(pair) for each pair of the last solve of these two, until one says so. Returns whether one did.
  template <typename Found>
  bool AnySolved(const EntityPair& entities, Found&& found) const;
  // The same with the points of each touch of these two that somebody who was woken remembers.
  template <typename Found>
  bool AnyRemembered(const EntityPair& entities, Found&& found) const;
  // The same with each point at which these two surfaces were pressed, in either of these.
  template <typename Found>
  bool AnyPressed(const ContactPair& pair, Found&& found) const;
  Placement Placed(GeometryRow row, const ImpactMotion& motion, double time) const;

  const ImpactWorld& world_;
  ImpactSpeed speed_;
  double step_size_;
  std::span<const FlownWay> ways_;
  std::vector<EntityRow> tipping_;
  // Whom the last solve pressed against somebody whom something can move, ascending, once somebody asked.
  mutable std::optional<std::vector<EntityRow>> among_others_;
  mutable OrderedSearch touching_search_;
  mutable OrderedSearch solved_search_;
};

}  // namespace genphys

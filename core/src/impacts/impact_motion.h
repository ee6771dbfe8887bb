#pragma once
#include "genphys/inertia.h"
#include "genphys/math.h"
#include "impacts/impact_solve.h"

namespace genphys {

/// How one body moves near the end of a substep as long as nothing hits it: with constant acceleration and angular
/// momentum, or on a way that joints lead it. Times are seconds before the end.
class ImpactMotion {
 public:
  /// Something that nothing can move: at `pose`, moving with the given velocities.
  static ImpactMotion Driven(const Pose& pose, const Vector3& linear_velocity, const Vector3& angular_velocity);

  /// A body at its true velocity at the end, with what accelerates it (m/s^2).
  static ImpactMotion Free(const Pose& pose, const MassProperties& mass, const Vector3& linear_velocity,
                           const Vector3& angular_velocity, const Vector3& acceleration);

  /// A body that was at `start` (pose of the entity's frame) `time` seconds ago, and got constant `acceleration`
  /// (m/s^2) and `torque` (N*m) since. What of its way its velocities do not explain was making up for errors. Whoever
  /// it is for adds what pushes it from a blow on, unless it `GoesOnPushed`.
  static ImpactMotion Along(const Pose& start, double time, const Pose& pose, const MassProperties& mass,
                            const Vector3& linear_velocity, const Vector3& angular_velocity,
                            const Vector3& acceleration, const Vector3& torque);

  /// Where the entity's frame was.
  Pose PoseBefore(double time) const;
  /// Where the point was about which it turns: the centre of mass, or the origin of the frame if nothing moves it.
  Vector3 CenterBefore(double time) const;
  /// How far (m) in the last `time` seconds a point that is no more than `reach` (m) from there may leave the straight
  /// line between where it is when they begin and when they end; infinite where that cannot be told.
  double BowMax(double time, double reach) const;
  /// What sped it up does so after a blow as well.
  void GoesOnPushed() { is_pushed_on_ = true; }
  /// From now on it works poses out from where it was `time` before the end: those near to that cost less then.
  void GoFrom(double time);
  /// How the body moved there.
  StruckBody BodyBefore(double time) const;

  /// The same body once it left from where it was `time` before the end as `struck`, and reached the end with the
  /// velocities of `end` (equal to what free motion gives unless something still supported it).
  ImpactMotion After(double time, const StruckBody& struck, const StruckBody& end) const;

  bool is_movable() const { return mass_ != nullptr; }
  const Pose& pose() const { return pose_; }
  const Vector3& linear_velocity() const { return linear_velocity_; }
  Vector3 angular_velocity() const;
  /// `struck` moved on for `time` with what goes on to speed it up: velocities only, kg*m^2/s kept.
  StruckBody Coast(const StruckBody& struck, double time) const;

 private:
  Vector3 CenterAt(const Pose& pose) const;

  const MassProperties* mass_ = nullptr;  // null: nothing moves it
  Pose pose_;                             // of the entity's frame, at the end
  Vector3 linear_velocity_ = Vector3::Zero();
  // A free body is known to have had this orientation, so long before the end, s.
  Quaternion known_ = Quaternion::Identity();
  double known_time_ = 0;
  Vector3 momentum_ = Vector3::Zero();  // angular; the angular velocity of what nothing moves
  Vector3 acceleration_ = Vector3::Zero();
  Vector3 torque_ = Vector3::Zero();
  // It came to its pose by these velocities at the end, m/s and rad/s, and this, rad/s^2, and not as its own say.
  bool is_led_ = false;
  bool is_pushed_on_ = true;
  Vector3 way_ = Vector3::Zero();
  Vector3 turn_ = Vector3::Zero();
  Vector3 turning_ = Vector3::Zero();
};

}  // namespace genphys

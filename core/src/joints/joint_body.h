#pragma once
#include <limits>

#include "genphys/ids.h"
#include "genphys/joint_row.h"
#include "genphys/math.h"

namespace genphys {

/// A body that joints hold, in a substep. What cannot be moved has zero inverses.
struct JointBody {
  EntityRow row = kWorldRow;
  Pose pose;
  Matrix3 axes = Matrix3::Identity();         // of the entity's frame, world, as columns
  Vector3 center = Vector3::Zero();           // of mass, world
  Vector3 linear_shown = Vector3::Zero();     // m/s, at the start of the substep
  Vector3 angular_shown = Vector3::Zero();    // rad/s
  Vector3 linear_before = Vector3::Zero();    // m/s, as the last substep left it, before forces act
  Vector3 angular_before = Vector3::Zero();   // rad/s
  Vector3 linear_velocity = Vector3::Zero();  // m/s, with the forces of this substep
  Vector3 angular_velocity = Vector3::Zero();
  Vector3 linear_given = Vector3::Zero();  // the same until the solve
  Vector3 angular_given = Vector3::Zero();
  Vector3 angular_kick = Vector3::Zero();                      // of that, by torques of the substep
  Vector3 momentum_given = Vector3::Zero();                    // kg*m^2/s, angular, with that spin before the solve
  double inverse_mass = 0;                                     // 1/kg
  Matrix3 own_tensor = Matrix3::Zero();                        // kg*m^2, world
  Matrix3 own_inverse = Matrix3::Zero();                       // of that, 1/(kg*m^2)
  Matrix3 inverse_tensor = Matrix3::Zero();                    // the same of what joints find
  double factor = 1;                                           // by which that is harder to turn: see InertiaFactor()
  double expected_factor = 1;                                  // the same before forces acted
  double interval = std::numeric_limits<double>::infinity();   // s, for which a solve acts on it
  double spin_most = std::numeric_limits<double>::infinity();  // rad/s, with which the substep may begin
  // What the velocities will be if contacts and joints go on as in the last substep, and where that leads.
  Vector3 linear_expected = Vector3::Zero();
  Vector3 angular_expected = Vector3::Zero();
  Vector3 center_ahead = Vector3::Zero();
  Quaternion turn_ahead = Quaternion::Identity();
  Matrix3 pull = Matrix3::Zero();  // N*m/rad, how hard joints turn it back: see PullStiffness()
  double pulled = 0;               // the size of that, as expected
  double pulled_most = 0;          // the same at most, as solved
  double swing = 0;                // (rad per substep)^2 under that, with its own tensor
  // The constant spin (rad/s) that turns it in the substep to where its momentum after the solve does: see
  // JointStep::Follow().
  Vector3 flow = Vector3::Zero();
  bool is_followed = false;
  bool begins = false;   // it begins anew or was hit, perhaps otherwise than others move
  bool goes_on = false;  // it does not, although from the boundary on something else acts on it
  bool is_late = false;  // a drive on it that is told otherwise is too stiff for the step

  bool is_movable() const { return inverse_mass > 0; }
  Vector3 VelocityAt(const Vector3& point) const { return linear_velocity + angular_velocity.cross(point - center); }
  Vector3 GivenAt(const Vector3& point) const { return linear_given + angular_given.cross(point - center); }
  Vector3 BeforeAt(const Vector3& point) const { return linear_before + angular_before.cross(point - center); }
  Vector3 ExpectedAt(const Vector3& point) const { return linear_expected + angular_expected.cross(point - center); }

  /// Takes back what solves gave it. Torques of the substep gave it as much as they give to what is as hard to turn as
  /// it is by now.
  void Return();

  /// Fills in where it is expected to be in `time` seconds, turned by `spin` (rad/s).
  void Foretell(double time, const Vector3& spin);
};

/// One side of a joint: its frame, on the body that it is fixed to.
struct JointSide {
  const JointBody* body;
  Pose frame;  // world

  /// Where `frame` of the body is now.
  static JointSide Now(const JointBody& body, const Pose& frame);
  /// Where this side is expected to be; see JointBody::Foretell().
  JointSide Ahead() const;

  Vector3 axis(int i) const { return frame.orientation.toRotationMatrix().col(i); }
};

}  // namespace genphys

#pragma once

#include "genphys/force_field.h"
#include "genphys/row_marks.h"

namespace genphys {

/// Force and torque about a centre of mass.
struct Wrench {
  Vector3 force = Vector3::Zero();   // N, world
  Vector3 torque = Vector3::Zero();  // N*m, world
};

/// Where a spring holds, in world coordinates.
struct SpringEnd {
  EntityRow row{};
  bool moves = false;                          // the spring can push it
  Vector3 point = Vector3::Zero();             // m
  Vector3 arm = Vector3::Zero();               // m, from the centre of mass
  Vector3 linear_velocity = Vector3::Zero();   // m/s, at the start of the substep
  Vector3 angular_velocity = Vector3::Zero();  // rad/s
  Vector3 gravity = Vector3::Zero();           // m/s^2, that acts on it
  double inverse_mass = 0;                     // 1/kg
  Matrix3 inverse_tensor = Matrix3::Zero();    // 1/(kg*m^2)
};

/// A spring of one substep.
struct TiedPair {
  const SpringField* spring = nullptr;
  SpringEnd a;
  SpringEnd b;
  Vector3 axis = Vector3::Zero();  // unit length, from a to b
  double length = 0;               // m
  double inverse_mass = 0;         // 1/kg, of both ends along the axis
  double pull = 0;                 // N, of each end towards the other

  /// False if it has no direction or nothing to move.
  bool Prepare();
  /// Of b against a along the axis, m/s, after `h` seconds of gravity and `wrenches`.
  double Speed(double h, const RowValues<Wrench>& wrenches) const;
  /// Up to when of a substep of `h` seconds its damper finds the velocity by which it pulls, s.
  double Reach(double h) const;
  /// The pull that belongs to the speed by then without it.
  double PullAt(double speed, double h) const;
  /// Adds a pull to what acts on both ends.
  void Push(double force, RowValues<Wrench>& wrenches) const;
  /// Its oscillation, by steps of `h` seconds.
  bool IsResolved(double h) const;
};

}  // namespace genphys

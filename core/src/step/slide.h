#pragma once
#include "genphys/math.h"

namespace genphys {

/// How a slip goes on: other things change it all the same way, and friction works against it.
class Slide {
 public:
  /// `slip` (m/s) that is changed by `drive` (m/s^2) and braked by `brake`; once it has stopped, friction holds up to
  /// `grip`.
  Slide(const Vector3& slip, const Vector3& drive, double brake, double grip)
      : begun_(slip), slip_(slip), drive_(drive), brake_(brake), grip_(grip) {}

  void GoOn(double time);

  const Vector3& slip() const { return slip_; }
  /// m, since it began.
  const Vector3& way() const { return way_; }
  /// s: the sum of its directions over time, until it stopped.
  const Vector3& led() const { return led_; }
  /// m/s, of what friction did to the slip.
  Vector3 braked() const { return slip_ - begun_ - whole_ * drive_; }
  bool has_stopped() const { return has_stopped_; }
  /// s, from when it began.
  double stopped_after() const { return time_; }
  /// Whether what drives it is more than friction holds.
  bool is_driven() const { return drive_.norm() > grip_; }

 private:
  Vector3 begun_, slip_, drive_;
  double brake_, grip_;
  Vector3 way_ = Vector3::Zero(), led_ = Vector3::Zero();
  double whole_ = 0;  // s
  double time_ = 0;   // s, of sliding before it stopped
  bool has_stopped_ = false;
};

}  // namespace genphys

#pragma once
#include <optional>

#include "absl/container/inlined_vector.h"
#include "genphys/force_field.h"
#include "genphys/math.h"

namespace genphys {

/// How a body goes, or what changes that.
struct Motion {
  Vector3 linear = Vector3::Zero();    // m/s, of the centre of mass
  Vector3 momentum = Vector3::Zero();  // N*m*s, angular, about that
};

/// The mean of exp(-x) from 0 to x: what is left of a steady push at the end of a time in which x is taken.
double MeanLeft(double x);

/// All that resists one body: its damping and the media that it is in.
class Resistance {
 public:
  /// The damping is in 1/s, and `inverse_tensor` in world axes.
  Resistance(double mass, const Matrix3& inverse_tensor, double linear_damping, double angular_damping);

  /// A medium, in which a `part` of the body is.
  void Add(const DragField& drag, double part);

  bool empty() const { return linear_rate_ == 0 && angular_rate_ == 0 && angular_ == 0 && media_.empty(); }

  /// How it goes after `time` seconds in which steady pushes alone would change it by `pushed`. What holds it pushes as
  /// well, and would change it by `given`: it is slowed down as it goes with that, but the result is without.
  Motion Slowed(double time, const Motion& before, const Motion& pushed, const Motion& given) const;

  /// Whether it takes most of what turns the body in `time` seconds.
  bool StopsTurning(double time) const;

  /// The mean spin over `time` seconds (rad/s, world) of a body that turned by `spin` in the middle if it had not
  /// turned until then, and on the mean by `freely` if nothing but its momentum led it: nearer to the former where
  /// media take most of that, and sooner than it turns. What drives it through these keeps it at a spin then and not at
  /// a momentum.
  Vector3 MeanSpin(double time, const Vector3& spin, const Vector3& freely) const;

 private:
  // One that resists more than in proportion to speed.
  struct Medium {
    double linear;     // N*s/m
    double quadratic;  // N*s^2/m^2
    Vector3 velocity;  // m/s
  };
  // v' = flow - rate v, 1/s and m/s^2: how all of them resist a velocity.
  struct Rate {
    double rate;
    Vector3 flow;
  };
  struct Balance {
    Vector3 velocity;  // m/s
    double rate;       // 1/s
  };

  Rate At(const Vector3& velocity) const;
  void Slow(const Medium& medium, double time, Vector3& velocity) const;
  void SlowInTurns(double time, Vector3& velocity) const;
  std::optional<Balance> BalanceWith(const Vector3& acceleration, const Rate& resistance) const;
  Vector3 SlowedVelocity(double time, const Vector3& before, const Vector3& pushed) const;
  Vector3 SlowedMomentum(double time, const Vector3& before, const Vector3& pushed) const;

  double mass_;
  const Matrix3& inverse_tensor_;
  double linear_rate_;                      // 1/s, of all that resists in proportion to speed
  Vector3 linear_flow_ = Vector3::Zero();   // m/s^2, of the same
  double angular_rate_;                     // 1/s
  double angular_ = 0;                      // N*m*s, of the media
  absl::InlinedVector<Medium, 2> media_{};  // all others
};

}  // namespace genphys

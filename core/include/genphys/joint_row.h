#pragma once
#include <cstdint>
#include <limits>

#include "genphys/ids.h"
#include "genphys/math.h"

namespace genphys {

/// The side of a joint that is no entity: it stands still and nothing moves it.
inline constexpr EntityRow kWorldRow{~uint32_t{0}};

/// One equation between the velocities of two bodies that a solve has to satisfy as far as the bounds of its impulse
/// let it: rate + softness * impulse = target. Only dynamic, active bodies are moved; all others go on as they do.
struct JointRow {
  static constexpr double kUnbounded = std::numeric_limits<double>::infinity();

  enum class Kind : uint8_t {
    kLinear,   // rate = axis * (velocity of b - velocity of a) at `point`; an impulse pushes b there and a back
    kAngular,  // rate = axis * (spin of b - spin of a)
    kGeared,   // rate = axis_b * spin of b + axis * spin of a; an impulse turns b along axis_b and a along axis
  };

  EntityRow a = kWorldRow;
  EntityRow b = kWorldRow;
  Kind kind = Kind::kLinear;
  /// This row and the block - 1 after it are linear at the same point, along perpendicular axes, unbounded and equally
  /// soft. One: nothing is said.
  uint8_t block = 1;
  bool is_driven = false;            // of a motor or spring, which may do work
  bool is_stuck = false;             // its errors wait, for something is in the way of making up for them
  Vector3 axis = Vector3::UnitZ();   // world; of unit length except in gears
  Vector3 point = Vector3::Zero();   // world, m
  Vector3 axis_b = Vector3::Zero();  // world
  double target = 0;                 // m/s or rad/s
  double softness = 0;               // 1/kg or 1/(kg*m^2): rate that an impulse of one leaves
  double repair = 0;                 // J: to make up for an error the solve may give so much
  bool is_reached = false;           // a limit that was not reached before comes up within the substep
  double leaving = 0;                // m/s or rad/s: so fast what pulls away from it will move off by the end of that
  double until = 0;                  // s, from the start of that until it is reached
  // Of a drive: what it gives for the whole time from the boundary on, by what it gave in the solve. Negative: that is
  // known of all that it is joined to together only.
  double since = -1;
  double damping = 0;          // N*s/m or N*m*s: by so much less a drive pushes on what a blow makes faster by one
  double rate = 0;             // m/s or rad/s, of what damps: on the mean of the solve
  double lower = -kUnbounded;  // N*s or N*m*s: either none, zero or minus `upper`
  double upper = kUnbounded;
  double impulse = 0;  // N*s or N*m*s: what the solve found; before that, what an engine may start from
};

}  // namespace genphys

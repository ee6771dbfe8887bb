#pragma once
#include <cstdint>

#include "genphys/ids.h"
#include "genphys/math.h"

namespace genphys {

/// What acts on a body from outside.
struct Push {
  Vector3 acceleration = Vector3::Zero();  // m/s^2
  Vector3 torque = Vector3::Zero();        // N*m
};

/// The tensors of a body as it is turned.
struct TurnedTensors {
  Matrix3 own = Matrix3::Zero();        // in the axes of the body: what the others are of
  Column4 turned_as = Column4::Zero();  // the orientation for which the following are, world
  Matrix3 axes = Matrix3::Identity();
  Matrix3 tensor = Matrix3::Zero();
  Matrix3 inverse = Matrix3::Zero();
};

/// Whether what acts on a body from outside begins it anew: not, by a change that may come again in every step, or by
/// one that may not.
enum class Beginning : uint8_t { kNone, kMay, kMust };

/// What the layer keeps of a moving dynamic body over a substep.
struct Mover {
  EntityRow row{};
  Pose start;                                // of the substep
  Vector3 linear_start = Vector3::Zero();    // at the start of the step
  Vector3 momentum_start = Vector3::Zero();  // angular, at the start of the step
  double past = 0;                           // s of the last substep that forces of fields are still owed for
  Push steady;                               // gravity and the forces of commands
  Beginning beginning = Beginning::kNone;
  bool goes_on = false;                    // although something else acts on it now
  Push field;                              // force fields and samples
  Push pull;                               // force fields, where the substep began
  Vector3 linear_given = Vector3::Zero();  // the engine was given
  Vector3 spin_given = Vector3::Zero();
  Vector3 momentum = Vector3::Zero();  // angular, in the middle of the substep without contacts and joints
  double yield = 1;                    // part by which torques turn it of what they else would: see InertiaFactor()
  Vector3 twist = Vector3::Zero();     // N*m*s, of all those up to the middle of the substep
  TurnedTensors turned;
};

}  // namespace genphys

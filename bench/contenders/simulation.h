#pragma once
#include <cstddef>
#include <span>
#include <stdexcept>

#include "genphys/math.h"
#include "genphys/world.h"

namespace genphys::bench {

/// What a body is doing, of its centre of mass, in world coordinates.
struct Motion {
  Vector3 position = Vector3::Zero();  // m
  Quaternion orientation = Quaternion::Identity();
  Vector3 velocity = Vector3::Zero();  // m/s
  Vector3 spin = Vector3::Zero();      // rad/s
};

/// What a contender has not, "ellipsoids": no failure, but an answer.
class NotHad : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A scene in the hands of one contender. Bodies and joints are named by their places in the scene. What goes wrong is
/// a std::runtime_error.
class Simulation {
 public:
  Simulation() = default;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  virtual ~Simulation() = default;

  virtual void Step(double step_size) = 0;
  /// Takes `count` steps and returns the processor time that they took, s.
  virtual double TimedSteps(double step_size, long count);
  virtual Motion MotionOf(size_t body) const = 0;

  /// From now on `force` (N) and `torque` (N*m), in world coordinates, act on the centre of mass of `body`.
  virtual void Hold(size_t body, const Vector3& force, const Vector3& torque) = 0;
  /// Changes the momentum of `body`, through its centre of mass, by `impulse` (N*s).
  virtual void Kick(size_t body, const Vector3& impulse) = 0;
  virtual void SetGravity(const Vector3& gravity) = 0;
  virtual void Remove(size_t body) = 0;
  virtual void Release(size_t joint) = 0;
  /// From now on the motors of these hinges, which drive to a position, do so to `positions` (rad), which go on at
  /// `velocities` (rad/s). Not of every contender: NotHad.
  virtual void Aim(std::span<const size_t> joints, std::span<const double> positions,
                   std::span<const double> velocities);

  /// Takes a step and says who took part in it. The engines alone do not tell where its time went.
  virtual StepStats Explain(double step_size) = 0;
};

}  // namespace genphys::bench

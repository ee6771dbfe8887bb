#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "genphys/bounded_solver.h"
#include "genphys/contact.h"
#include "genphys/contact_memory.h"
#include "genphys/joint_row.h"
#include "genphys/math.h"

namespace genphys {

/// A body in a solve of contacts, world. What is not dynamic goes on as it does, whatever pushes it.
struct SweptBody {
  bool is_dynamic = false;
  double inverse_mass = 0;                     // 1/kg
  Matrix3 inverse_tensor = Matrix3::Zero();    // about the centre of mass, 1/(kg*m^2)
  Vector3 center = Vector3::Zero();            // of mass, m
  Vector3 linear_velocity = Vector3::Zero();   // m/s
  Vector3 angular_velocity = Vector3::Zero();  // rad/s
  // On top of the velocities, for this step's move alone: what takes overlaps apart.
  Vector3 push = Vector3::Zero();  // m/s
  Vector3 turn = Vector3::Zero();  // rad/s
};

/// The pose at which `pose` is after `step_size` s of what a solve found for the body.
Pose MovedBy(const SweptBody& body, double step_size, const Vector3& center_of_mass, const Pose& pose);

/// Solves contacts and joints between the bodies of one island by sweeps over their rows (projected Gauss-Seidel) that
/// start from what held the contacts in the last solve, keep the friction of a point in a circle, pass over what no
/// longer changes, and end when that is all. How often they sweep, and in which order, must not depend on what is
/// elsewhere. Overlap is taken away by moving bodies apart, never by a velocity, so that what rests has no speed.
class ContactSweeps {
 public:
  /// The iterations of every preset.
  static constexpr uint32_t kPresetIterations = 10;
  /// Few points get more iterations than a preset's, for this much work: what rests then stays where it is also
  /// when the impulses to start from are another engine's.
  static constexpr size_t kPointUpdates = 2000;
  /// Points that get more than that.
  static constexpr size_t kFewPoints = kPointUpdates / kPresetIterations;
  /// The number of all that stands still and cannot be moved.
  static constexpr uint32_t kFixed = 0;

  ContactSweeps();
  ~ContactSweeps();
  ContactSweeps(const ContactSweeps&) = delete;
  ContactSweeps& operator=(const ContactSweeps&) = delete;

  /// Few contacts get more where they `may_go_on`.
  void SetIterations(uint32_t iterations, bool may_go_on);

  /// Starts with nothing, which will be solved for a step of `step_size` seconds; `pull` as in ContactBuffer. With
  /// `are_few` there will be no more than kFewPoints points and no joints.
  void Begin(double step_size, double pull, bool are_few);

  /// Adds a body, and returns its number. Each one that a pair or a row names must be added, and once.
  uint32_t AddBody(const SweptBody& body);

  /// Adds a pair between two numbers. `impulses` are where its points start from; Solve() writes what they came to
  /// into both. All that is given here must last until then.
  void AddPair(uint32_t a, uint32_t b, const ContactPair& pair, std::span<ContactPoint> points,
               std::span<PointImpulse> impulses);

  /// Adds a row of a joint; kFixed is a side that cannot be moved and stands still. Solve() writes its impulse back.
  void AddRow(uint32_t a, uint32_t b, JointRow& row);

  /// Solves in sweeps.
  void Solve();

  /// Solves all at once, if need be and if there is one with the help of `bounded`. If the equations do not let it, it
  /// sweeps, or if it may not, does nothing and returns false.
  bool SolveDirectly(BoundedSolver* bounded, bool may_sweep);

  /// A body by its number: what Solve() made of it.
  const SweptBody& body(uint32_t number) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace genphys

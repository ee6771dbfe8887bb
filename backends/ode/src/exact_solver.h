#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "friction_lines.h"
#include "genphys/contact.h"
#include "genphys/error_correction.h"
#include "genphys/inertia.h"
#include "row_composer.h"

struct dContact;
struct dxBody;
struct dxJointGroup;
struct dxThreadingImplementation;
struct dxWorld;
struct dJointFeedback;

namespace genphys::ode_backend {

/// Position of the centre of mass, orientation, and velocities, world.
struct Motion {
  Vector3 position = Vector3::Zero();
  Quaternion orientation = Quaternion::Identity();
  Vector3 linear_velocity = Vector3::Zero();
  Vector3 angular_velocity = Vector3::Zero();
};

/// A point at which `body` is pushed along `normal`, away from another body or from what no push moves.
struct ContactConstraint {
  static constexpr uint32_t kImmovable = ~uint32_t{0};

  uint32_t body = 0;
  uint32_t other = kImmovable;
  Vector3 position = Vector3::Zero();           // world
  Vector3 normal = Vector3::UnitZ();            // unit length, into `body`
  double depth = 0;                             // m
  double bend = 0;                              // m/s, by which it parts faster in the middle of the step
  double friction = 0;                          // Coulomb coefficient
  Vector3 relative_velocity = Vector3::Zero();  // of `body` at the point against the other side, m/s
  Vector3 slip = Vector3::Zero();               // m/s, of that along the surface, in the middle of the step
  // m/s, at the point, at which there is none: of an immovable other side, less how the surface of `body` runs.
  Vector3 other_velocity = Vector3::Zero();
  double grip = 0;                  // N*s, the most that friction could have given in the last solve
  Vector3 drawn = Vector3::Zero();  // m/s, by which it would slip faster after the solve were there no friction
  bool is_jointed = false;          // its island has joints
  ErrorCorrection correction;
  double rolling_friction = 0;              // m
  double spinning_friction = 0;             // m
  Vector3 relative_spin = Vector3::Zero();  // of `body` against the other side, rad/s
  Vector3 rolling = Vector3::Zero();        // rad/s, the same in the middle of the step
  double load = 0;                          // N*s, by which the pair was pressed in the last solve
  Vector3 other_spin = Vector3::Zero();     // of an immovable other side, rad/s
  double softness = 1;                      // how much it gives way, of what others do
};

/// One ODE world as a solver of all contacts and joints of an island at once. It remembers nothing from one solve to
/// the next: what a solve gives depends on what was put in since Begin() and on the step size.
class ExactSolver {
 public:
  ExactSolver();
  ~ExactSolver();
  ExactSolver(const ExactSolver&) = delete;
  ExactSolver& operator=(const ExactSolver&) = delete;

  /// Lets go of memory that is far more than what `count` bodies at a time and the solves since the last call need. For
  /// once a step: of its solves one may be of a thousand bodies and the next one of two.
  void Trim(uint32_t count);
  /// Starts a solve of `count` bodies over `step_size` seconds, without contacts yet; see ContactBuffer::pull.
  void Begin(uint32_t count, double step_size, double pull);
  /// Each of 0..count-1 must be set.
  void SetBody(uint32_t body, const MassProperties& mass, const Motion& motion);
  /// Whether contacts, with or without joints, can be solved all at once, the easiest of which gives way to a push
  /// `spread` times more than the hardest.
  static bool MaySolve(bool is_jointed, double spread);

  /// Tells how many contacts and rows of joints will be added at most; must be called before the first.
  void Reserve(size_t contacts, size_t rows);
  /// Adds the rows of one block; see RowComposer.
  void AddRows(std::span<JointRow> block, uint32_t body_a, uint32_t body_b, std::span<const double> given_rates);
  void AddContact(const ContactConstraint& contact);
  /// Solves and moves. An EngineFault out of here leaves nothing to go on with.
  void Step();
  /// After Step(): whether friction goes other ways than it should. All is then to be set and added again as it was, to
  /// be solved along other lines; the same if the step `failed` and an earlier one did not.
  bool IsToBeSolvedAnew(bool failed);

  Motion motion(uint32_t body) const;
  /// N*s on the `body` of the contact that was added as the `contact`th.
  Vector3 Impulse(size_t contact) const;
  /// Writes impulses back into all rows that were added.
  void TakeRowImpulses() { composer_.TakeImpulses(); }

 private:
  void EmptyGroup();
  // Takes out what was added, and what it lent.
  void Rewind();
  void Grow(uint32_t count);
  void Shrink(uint32_t count);
  double InverseMass(const ContactConstraint& contact) const;
  // s/kg, of a force.
  double Softness(const ContactConstraint& contact) const;
  void SetTorsion(const ContactConstraint& contact, dContact& to);
  dxBody* OtherBody(const ContactConstraint& contact);

  dxThreadingImplementation* threading_;
  dxWorld* world_;
  dxJointGroup* contacts_;
  size_t most_joints_ = 0;    // that it had at a time
  size_t recent_joints_ = 0;  // the same since the last Trim()
  RowComposer composer_;
  // ODE walks its bodies from the last created to the first, so that only the number of bodies in use matters.
  std::vector<dxBody*> bodies_;
  std::vector<MassProperties> masses_;  // that they have now; none at all before the first
  uint32_t body_count_ = 0;             // in use; the others are disabled
  // Sides that turn although nothing turns them: ODE knows targets for slip but none for rolling. The first
  // turner_count_ are in use, at their contacts, the others disabled.
  std::vector<dxBody*> turners_;
  size_t turner_count_ = 0;
  std::vector<dJointFeedback> feedback_;  // by contact
  size_t contact_count_ = 0;
  FrictionLines lines_;  // of contacts
  size_t row_count_ = 0;
  double torsion_softness_ = 0;  // of all rows against rolling and spinning; zero: there are none
  double step_size_ = 0;
  double pull_ = 0;  // m/s^2, of gravity
  bool is_faulted_ = false;
};

}  // namespace genphys::ode_backend

#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "genphys/contact.h"
#include "genphys/error_correction.h"
#include "genphys/inertia.h"
#include "genphys/stepper.h"
#include "row_composer.h"
#include "row_order.h"

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
  double friction = 0;                          // Coulomb coefficient
  Vector3 relative_velocity = Vector3::Zero();  // of `body` at the point against the other side, m/s
  Vector3 slip = Vector3::Zero();               // m/s, of that along the surface, in the middle of the step
  // m/s, at the point, at which there is none: of an immovable other side, less how the surface of `body` runs.
  Vector3 other_velocity = Vector3::Zero();
  Vector3 braked = Vector3::Zero();  // N*s, what friction gave to `body` in the last solve
  double grip = 0;                   // N*s, the most that it could have been
  Vector3 drawn = Vector3::Zero();   // m/s, by which it would slip faster after the solve were there no friction
  bool is_jointed = false;           // its island has joints
  ErrorCorrection correction;
  // Along which of two axes it holds for others of its pair, too, if they share the work of friction among them.
  std::optional<uint32_t> shared_axis;
  double rolling_friction = 0;              // m
  double spinning_friction = 0;             // m
  Vector3 relative_spin = Vector3::Zero();  // of `body` against the other side, rad/s
  Vector3 other_spin = Vector3::Zero();     // of an immovable other side, rad/s
  double softness = 1;                      // how much it gives way where all are solved at once, of what others do
  // N*s on `body` from which the solve starts, if not zero. It then holds the sides together, in all directions and
  // however hard: it is for the caller to see whether contact and friction can do that.
  Vector3 given = Vector3::Zero();
};

/// One ODE world as a solver of contacts and joints. It remembers nothing from one solve to the next: what a solve
/// gives depends on what was put in since Begin() and on the step size.
class ContactSolver {
 public:
  /// The iterations of every preset, where many rows are solved at once; fewer rows get more. Fewer than the library's
  /// 20: 1,000 boxes in a pile overlap less with two substeps of 10 than with one of 20, at the same price (by 0.60 and
  /// 0.77 mm in the mean). The last one is that of friction: see RowOrder.
  static constexpr uint32_t kPresetIterations = 17;

  explicit ContactSolver(const StepperSettings& settings);
  ~ContactSolver();
  ContactSolver(const ContactSolver&) = delete;
  ContactSolver& operator=(const ContactSolver&) = delete;

  void SetStepper(const StepperSettings& settings) { settings_ = settings; }

  /// Lets go of memory that is far more than what `count` bodies at a time and the solves since the last call need. For
  /// once a step: of its solves one may be of a thousand bodies and the next one of two.
  void Trim(uint32_t count);
  /// Starts a solve of `count` bodies over `step_size` seconds, without contacts yet; see ContactBuffer::pull.
  void Begin(uint32_t count, double step_size, double pull);
  /// Each of 0..count-1 must be set.
  void SetBody(uint32_t body, const MassProperties& mass, const Motion& motion);
  /// Whether so many contacts and rows can be solved all at once, the easiest of which gives way to a push `spread`
  /// times more than the hardest.
  static bool MayBeDirect(size_t contacts, size_t rows, double spread);
  /// Whether an island has so many contacts that points of a pair may share the work of friction.
  static bool MayShareFriction(size_t contacts);

  /// Tells how many contacts, how many of them with something given, and rows of joints will be added at most, and
  /// whether they are solved all at once; must be called before the first.
  void Reserve(size_t contacts, size_t held, size_t rows, bool direct);
  /// Adds the rows of one block; see RowComposer.
  void AddRows(std::span<JointRow> block, uint32_t body_a, uint32_t body_b, std::span<const double> given_rates);
  void AddContact(const ContactConstraint& contact);
  /// Solves and moves, `briefly` with few sweeps however few rows there are. An EngineFault out of here leaves
  /// nothing to go on with.
  void Step(bool briefly = false);

  Motion motion(uint32_t body) const;
  /// N*s on the `body` of the contact that was added as the `contact`th, once impulses were taken.
  Vector3 Impulse(size_t contact) const;
  /// m/s of that contact before the solve.
  double SpeedBefore(size_t contact) const { return given_[contact].speed; }
  /// m/s by which that contact misses what it aims at; zero unless something was given to it.
  double Residual(size_t contact) const;
  /// Writes impulses back into all rows that were added.
  void TakeRowImpulses() { composer_.TakeImpulses(); }

 private:
  static constexpr size_t kNotHeld = ~size_t{0};
  struct Given {
    Vector3 impulse = Vector3::Zero();
    size_t first_row = kNotHeld;  // of three in held_rows_
    uint32_t body = 0;
    uint32_t other = ContactConstraint::kImmovable;
    double speed = 0;  // m/s, of one side against the other before
  };

  void AddHeld(const ContactConstraint& contact, double parting_speed);
  void EmptyGroup();
  void Grow(uint32_t count);
  void Shrink(uint32_t count);
  double InverseMass(const ContactConstraint& contact) const;
  double Softness(const ContactConstraint& contact) const;
  void SetTorsion(const ContactConstraint& contact, dContact& to);
  dxBody* OtherBody(const ContactConstraint& contact);
  uint32_t Iterations() const;
  bool AreMany() const;
  uint32_t Seed() const;
  void StirSeed(double value);

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
  std::vector<dJointFeedback> feedback_;
  std::vector<Given> given_;  // by contact
  std::vector<JointRow> held_rows_;
  size_t contact_count_ = 0;
  size_t row_count_ = 0;
  size_t bounded_count_ = 0;  // of these, that others bound
  RowOrder row_order_;
  double torsion_softness_ = 0;  // of all rows against rolling and spinning; zero: there are none
  double step_size_ = 0;
  double pull_ = 0;  // m/s^2, of gravity
  bool is_direct_ = false;
  StepperSettings settings_;
  // Of the random order of rows: drawn from the contacts, so that it is part of no state, and yet differs from step to
  // step. The same order at each step would push in the same direction each time, and a stack would creep.
  uint64_t seed_ = 0;
  bool is_faulted_ = false;
};

}  // namespace genphys::ode_backend

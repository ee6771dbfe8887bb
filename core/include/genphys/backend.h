#pragma once
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "genphys/capabilities.h"
#include "genphys/contact.h"
#include "genphys/entity.h"
#include "genphys/inertia.h"
#include "genphys/joint_row.h"
#include "genphys/state.h"
#include "genphys/status.h"
#include "genphys/stepper.h"

namespace genphys {

/// The engine gave up inside a call. The world that threw it is beyond use; others are not affected.
class EngineFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One physical entity as an engine needs it. References live for the call only.
struct BodyDesc {
  EntityRow row{};
  EntityId id;
  const RigidBody& body;                    // validated, materials filled
  const MassProperties& mass;               // meaningful for dynamic bodies
  std::span<const GeometryRow> geometries;  // parallel to body.geometries
};

/// A body whose tensor is to be taken `factor` times as large in one solve, for joints pull it too hard for the step.
struct InertiaScale {
  EntityRow row{};
  double factor = 1;
};

/// One engine's worth of one world. Called by one thread at a time. Every argument has been validated and checked
/// against the engine's capabilities. The layer finds who is near whom and owns gravity, forces, damping, gyroscopic
/// terms, restitution, sleeping, the motion of kinematic bodies, rays and what joints mean: the engine finds contact
/// points, solves contacts and the rows of joints, and moves bodies with the solved velocities. Any call may throw
/// EngineFault; the layer then discards this object.
class BackendWorld {
 public:
  virtual ~BackendWorld() = default;

  /// Adds a body at the pose and velocity of its row in `state`, active. Order of calls is order of ids.
  virtual void AddBody(const BodyDesc& desc, const StateArrays& state) = 0;
  virtual void RemoveBody(EntityRow row) = 0;

  /// Inactive bodies are kept for active ones to touch, weigh infinitely much, and do not move.
  virtual void SetActive(std::span<const EntityRow> rows, bool active) = 0;

  /// Those that a step put to sleep are all inactive by now. What is to be done once for them is done here, and not in
  /// the step in which the first of them is woken: that has one body to care for, and this one had all of them.
  virtual void PutAway() {}

  /// Takes pose and velocity of `rows` from `state`.
  virtual void WriteState(std::span<const EntityRow> rows, const StateArrays& state) = 0;

  virtual void SetStepper(const StepperSettings& settings) = 0;

  /// Appends the points at which two geometries meet at their current poses, with normals from `a` towards `b`; none
  /// for a gap of more than kContactGapMax. `a` comes first in canonical order.
  virtual void FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) = 0;

  /// Solves `contacts` (points found at the current poses, in canonical order) and moves the dynamic `rows` (active,
  /// ascending) by `step_size` seconds: reads velocities of `rows` from `state`, overwrites pose and velocity there,
  /// and fills in the impulses. Velocities include this step's gravity and forces already. Kinematic bodies push with
  /// their velocity in `state`; the layer moves them. Sensor pairs push nothing. `joint_rows` are solved together with
  /// the contacts, and their impulses written back.
  virtual void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                     std::span<JointRow> joint_rows) = 0;

  /// Solves islands of the last Solve() once more, from where it began and with other targets of their joint rows: all
  /// `rows` of these islands, which the layer brought back, and the contacts as they were. It starts from nothing, for
  /// sweeps give no energy then, wherever they stop, and what is remembered for the next Solve() stays as the last one
  /// left it.
  virtual void SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state,
                          ContactBuffer& contacts, std::span<JointRow> joint_rows) {
    Solve(step_size, rows, state, contacts, joint_rows);
  }

  /// Which bodies are harder to turn in the next Solve(), and in no other; an engine without joints is given none.
  virtual void ScaleInertia(std::span<const InertiaScale> scales) { static_cast<void>(scales); }

  /// Impulses that held these contacts at the last solve, by another engine: a start for the next solve here. Called
  /// once, when all bodies are added; an engine that starts every solve from nothing has no use for it.
  virtual void Recall(const ContactBuffer& solved) { static_cast<void>(solved); }

  /// Appends all private state that the future depends on beyond what the layer knows (seeds, cached impulses).
  virtual void SaveState(std::string& bytes) const = 0;
};

/// One engine, able to make worlds. Stateless and shared by all threads.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual const Capabilities& capabilities() const = 0;
  /// What a quality preset means here. The solver is the one that was asked for: what `automatic` means is decided for
  /// each island.
  virtual StepperSettings Resolve(const StepperDesc& stepper) const = 0;
  virtual std::unique_ptr<BackendWorld> CreateWorld(const StepperSettings& settings) const = 0;
  /// Called once before the first world: OK if the engine as linked behaves as the adapter needs it to.
  virtual Status SelfTest() const = 0;
};

}  // namespace genphys

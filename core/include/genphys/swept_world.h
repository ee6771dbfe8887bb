#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "genphys/backend.h"
#include "genphys/contact_memory.h"
#include "genphys/contact_sweeps.h"
#include "genphys/islands.h"
#include "genphys/joint_memory.h"
#include "genphys/placement.h"

namespace genphys {

/// One geometry where it now is.
struct PlacedGeometry {
  EntityRow entity{};
  uint32_t id = 0;  // unique in its entity
  Pose pose_in_entity;
  Shape shape;
  Placement placement;  // of the shape's own frame, world
};

/// All of a world on an engine but how geometries meet: bodies, what is remembered of the last solve, and islands,
/// which the layer sweeps unless the engine solves them itself. What it gives depends on the columns, the active set
/// and the saved impulses alone, not on how these came about.
class SweptWorld : public BackendWorld {
 public:
  /// An island without joints is solved all at once, unless asked otherwise, while it has no more points than this, if
  /// weights in it are uneven. Of boxes on top of each other, the topmost a hundred times as heavy, that takes as long
  /// as sweeps for eight of them, and 1.6 times as long for twelve, of which sweeps let the topmost fall.
  static constexpr size_t kUnevenPointsMax = 48;

  explicit SweptWorld(const StepperSettings& settings);

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override;
  void SetActive(std::span<const EntityRow> rows, bool active) override;
  void PutAway() override;
  void WriteState(std::span<const EntityRow> rows, const StateArrays& state) override;
  void SetStepper(const StepperSettings& settings) override;
  void ScaleInertia(std::span<const InertiaScale> scales) override;
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows) override;
  void SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) override;
  void Recall(const ContactBuffer& solved) override;
  void SaveState(std::string& bytes) const override;

 protected:
  /// The number of a body that is in no solve, or cannot be moved in it.
  static constexpr uint32_t kUnsolved = ~uint32_t{0};

  struct Body {
    EntityId id;  // null: none in this row
    MotionType motion_type = MotionType::kStatic;
    bool is_active = false;
    bool is_moved = false;  // its geometries are not yet where its pose says
    Pose pose;
    MassProperties mass;          // of dynamic ones
    double inertia_factor = 1;    // by which it is harder to turn in the next solve
    uint32_t number = kUnsolved;  // in the solve of its island, while that lasts
    std::vector<GeometryRow> geometries;

    Vector3 CenterOfMass() const;   // m, world
    Matrix3 InverseTensor() const;  // in the next solve, world
  };

  /// What a solve is of; see BackendWorld::Solve().
  struct Call {
    double step_size;
    StateArrays& state;
    ContactBuffer& contacts;
    std::span<JointRow> joint_rows;

    std::span<ContactPoint> PointsOf(const ContactPair& pair) const {
      return std::span(contacts.points).subspan(pair.first_point, pair.point_count);
    }
  };

  /// Solves an island of islands() and moves its bodies.
  virtual void SolveIsland(uint32_t island, const Call& call) { Sweep(island, call); }
  /// A geometry was placed anew.
  virtual void Follow(GeometryRow row, const PlacedGeometry& geometry) {
    static_cast<void>(row);
    static_cast<void>(geometry);
  }

  /// Whether an island is to be solved all at once, by what was asked for and by its size. Not if something is in the
  /// way of its joints: of what contradicts itself sweeps keep those apart that touch.
  bool IsForDirect(uint32_t island, const Call& call) const;
  /// See PushSpread.
  double SpreadOf(uint32_t island, const Call& call) const;
  /// Has the layer solve an island; see ContactSweeps::Solve().
  void Sweep(uint32_t island, const Call& call);
  /// The same all at once; see ContactSweeps::SolveDirectly().
  bool SolveDirectly(uint32_t island, const Call& call, BoundedSolver* bounded, bool may_sweep);
  /// A body goes to `pose` with the velocities that it has in `state`. Throws EngineFault if any of it is not finite.
  void Move(EntityRow row, const Pose& pose, StateArrays& state);

  /// The geometry, where its body is now.
  const PlacedGeometry& Placed(GeometryRow row);
  /// False of the world itself and of entities without physics.
  bool IsBody(EntityRow row) const { return Index(row) < bodies_.size() && !bodies_[Index(row)].id.is_null(); }
  Body& body(EntityRow row) { return bodies_[Index(row)]; }
  const Body& body(EntityRow row) const { return bodies_[Index(row)]; }
  const StepperSettings& settings() const { return settings_; }
  const Islands& islands() const { return islands_; }
  /// Of the contact pairs of this solve.
  std::span<ContactMemory::Pair> remembered() { return memory_.pairs(); }

 private:
  void SetPose(EntityRow row, const Pose& pose);
  void CheckVelocity(EntityRow row, const StateArrays& state) const;
  // Null of the world and of entities without physics.
  EntityId IdOf(EntityRow row) const { return IsBody(row) ? body(row).id : EntityId(); }
  ContactMemory::Motion MotionOf(EntityId id) const;
  std::pair<ContactMemory::Key, Placement> Identify(const ContactPair& pair);
  SweptBody Swept(EntityRow row, const StateArrays& state) const;
  uint32_t NumberOf(EntityRow row, const StateArrays& state);
  void LoadSweeps(uint32_t island, const Call& call);
  void TakeSweeps(uint32_t island, const Call& call, bool is_solved);
  void TakeSwept(EntityRow row, const SweptBody& swept, const Call& call);

  std::vector<Body> bodies_;                // by entity row
  std::vector<PlacedGeometry> geometries_;  // by geometry row
  StepperSettings settings_;
  ContactMemory memory_;  // its pairs are those of the last Solve()
  JointMemory joint_memory_;
  ContactSweeps sweeps_;
  // Kept between calls for their memory only.
  Islands islands_;
  std::vector<EntityRow> scaled_;  // who is harder to turn
  std::vector<EntityRow> driven_;  // of the island that is being swept, who moves by itself
};

}  // namespace genphys

#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "exact_solver.h"
#include "genphys/backend.h"
#include "genphys/contact_memory.h"
#include "genphys/contact_sweeps.h"
#include "genphys/islands.h"
#include "genphys/push_spread.h"
#include "shapes.h"

namespace genphys::ode_backend {

/// A world on ODE. The library's collision pairs and exact solver are used, and none of its spaces: what it gives
/// depends on the columns, the active set and the saved impulses alone, not on how these came about. Islands that are
/// not for the exact solver are left to the sweeps of the layer.
class World final : public BackendWorld {
 public:
  explicit World(const StepperSettings& settings) { SetStepper(settings); }

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override;
  void SetActive(std::span<const EntityRow> rows, bool active) override;
  void WriteState(std::span<const EntityRow> rows, const StateArrays& state) override;
  void SetStepper(const StepperSettings& settings) override;
  void FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) override;
  void ScaleInertia(std::span<const InertiaScale> scales) override;
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows) override;
  void SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) override;
  void Recall(const ContactBuffer& solved) override;
  void SaveState(std::string& bytes) const override;

 private:
  static constexpr uint32_t kUnsolved = ContactConstraint::kImmovable;

  struct Body {
    EntityId id;  // null: none in this row
    MotionType motion_type = MotionType::kStatic;
    bool is_active = false;
    bool is_moved = false;  // its geometries are not yet where its pose says
    Pose pose;
    bool is_centered = true;         // the centre of mass is the origin of the entity's frame
    uint32_t solved_as = kUnsolved;  // place in the solver or number in the sweeps, during a solve
    MassProperties mass;
    double inertia_factor = 1;  // by which it is harder to turn in the next solve
    std::vector<GeometryRow> geometries;
  };

  // A contact's side as the exact solver needs it.
  struct Side {
    uint32_t solved_as = kUnsolved;
    Vector3 center = Vector3::Zero();            // of mass, world
    Vector3 linear_velocity = Vector3::Zero();   // m/s
    Vector3 angular_velocity = Vector3::Zero();  // rad/s

    Vector3 VelocityAt(const Vector3& point) const { return linear_velocity + angular_velocity.cross(point - center); }
    double RateOf(const JointRow& row, const Vector3& axis) const {
      return axis.dot(row.kind == JointRow::Kind::kLinear ? VelocityAt(row.point) : angular_velocity);
    }
  };

  static void Move(Body& body, const Pose& pose);
  void PlaceMoved(GeometryRow row);
  bool IsBody(EntityRow row) const { return Index(row) < bodies_.size() && !bodies_[Index(row)].id.is_null(); }
  Motion MotionOf(EntityRow row, const StateArrays& state) const;
  void CheckFinite(EntityRow row, const StateArrays& state) const;
  void StorePose(EntityRow row, const Pose& pose, StateArrays& state);

  // What is remembered of the last solve.
  ContactMemory::Motion MemoryMotionOf(EntityId id) const;
  std::pair<ContactMemory::Key, Placement> Identify(const ContactPair& pair);

  void SolveIslands(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                    std::span<JointRow> joint_rows);

  // In sweeps.
  void Sweep(uint32_t island, double step_size, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows);
  SweptBody Swept(EntityRow row, const StateArrays& state) const;
  uint32_t NumberOf(EntityRow row, const StateArrays& state);

  // All at once. See world_exact.cc.
  bool IsExact(uint32_t island, const StateArrays& state, const ContactBuffer& contacts,
               std::span<const JointRow> joint_rows, double& softness) const;
  bool SolveExactly(uint32_t island, double softness, double step_size, StateArrays& state, ContactBuffer& contacts,
                    std::span<JointRow> joint_rows);
  bool StepExactly(uint32_t island);
  void LoadBodies(uint32_t island, const StateArrays& state);
  void LoadRows(uint32_t island, const StateArrays& state, std::span<JointRow> joint_rows);
  void LoadContacts(uint32_t island, double softness, const StateArrays& state, const ContactBuffer& contacts);
  void LoadContact(const ContactPair& pair, const ContactPoint& point, const Side& pushed, const Side& other,
                   double sign, ContactConstraint contact);
  Side SideOf(EntityRow row, const StateArrays& state) const;
  void StoreImpulses(ContactBuffer& contacts);
  void StoreBodies(uint32_t island, StateArrays& state);

  std::vector<Body> bodies_;         // by entity row
  std::vector<PlacedShape> shapes_;  // by geometry row
  StepperSettings settings_;
  ContactMemory memory_;  // its pairs are those of the last Solve()
  ContactSweeps sweeps_;
  std::optional<ExactSolver> exact_;  // made when it is first needed
  uint32_t most_exact_ = 0;           // bodies that it had at a time in this step
  // It gave up in the middle of a solve. It is not asked again, for each time it leaves memory behind.
  bool has_failed_exactly_ = false;

  struct Solved {
    uint32_t pair = 0;   // in the contact buffer
    uint32_t point = 0;  // of it
    double sign = 1;     // -1 where the solver pushed a instead of b
  };
  // Kept between calls for their memory only.
  Islands islands_;
  std::vector<EntityRow> scaled_;  // who is harder to turn
  std::vector<EntityRow> driven_;  // of the island that is being swept, who moves by itself
  std::vector<Solved> solved_;     // of the island that is being solved all at once
};

}  // namespace genphys::ode_backend

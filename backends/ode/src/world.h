#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "exact_solver.h"
#include "genphys/swept_world.h"
#include "shapes.h"

namespace genphys::ode_backend {

/// A world on ODE. The library's collision pairs and exact solver are used, and none of its spaces. Islands that are
/// not for the exact solver are left to the sweeps of the layer.
class World final : public SweptWorld {
 public:
  using SweptWorld::SweptWorld;

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override;
  void FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) override;
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows) override;
  void SaveState(std::string& bytes) const override;

 private:
  // A contact's side as the exact solver needs it.
  struct Side {
    uint32_t number = kUnsolved;
    Vector3 center = Vector3::Zero();            // of mass, world
    Vector3 linear_velocity = Vector3::Zero();   // m/s
    Vector3 angular_velocity = Vector3::Zero();  // rad/s

    Vector3 VelocityAt(const Vector3& point) const { return linear_velocity + angular_velocity.cross(point - center); }
    double RateOf(const JointRow& row, const Vector3& axis) const {
      return axis.dot(row.kind == JointRow::Kind::kLinear ? VelocityAt(row.point) : angular_velocity);
    }
  };

  void Follow(GeometryRow row, const PlacedGeometry& geometry) override { shapes_[Index(row)].Follow(geometry); }

  // See world_exact.cc.
  void SolveIsland(uint32_t island, const Call& call) override;
  bool IsExact(uint32_t island, const Call& call, double& softness) const;
  bool SolveExactly(uint32_t island, double softness, const Call& call);
  bool StepExactly(uint32_t island);
  bool IsJammed(uint32_t island, const Call& call) const;
  void LoadBodies(uint32_t island, const StateArrays& state);
  void LoadRows(uint32_t island, const Call& call);
  void LoadContacts(uint32_t island, double softness, const Call& call);
  void LoadContact(const ContactPair& pair, const ContactPoint& point, const Side& pushed, const Side& other,
                   double sign, ContactConstraint contact);
  Motion MotionOf(EntityRow row, const StateArrays& state) const;
  Side SideOf(EntityRow row, const StateArrays& state) const;
  void StoreImpulses(ContactBuffer& contacts);
  void StoreBodies(uint32_t island, StateArrays& state);

  std::vector<OdeShape> shapes_;      // by geometry row
  std::optional<ExactSolver> exact_;  // made when it is first needed
  uint32_t most_exact_ = 0;           // bodies that it had at a time in this step
  // It gave up in the middle of a solve. It is not asked again, for each time it leaves memory behind.
  bool has_failed_exactly_ = false;

  struct Solved {
    uint32_t pair = 0;   // in the contact buffer
    uint32_t point = 0;  // of it
    double sign = 1;     // -1 where the solver pushed a instead of b
  };
  std::vector<Solved> solved_;  // of the island that is being solved all at once
};

}  // namespace genphys::ode_backend

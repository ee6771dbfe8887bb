#pragma once
#include <memory>
#include <string>
#include <vector>

#include "body.h"
#include "contact_solver.h"
#include "genphys/backend.h"
#include "genphys/contact_memory.h"
#include "genphys/islands.h"
#include "genphys/push_spread.h"

namespace genphys::bullet_backend {

/// A world on Bullet. The library's detectors and solver are used, and none of its worlds, dispatchers, trees and
/// pools: what it gives depends on the columns, the active set and the saved impulses alone, not on how these came
/// about.
class World final : public BackendWorld {
 public:
  explicit World(const StepperSettings& settings) : settings_(settings) { SetStepper(settings); }

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override;
  void SetActive(std::span<const EntityRow> rows, bool active) override;
  void WriteState(std::span<const EntityRow> rows, const StateArrays& state) override;
  void SetStepper(const StepperSettings& settings) override {
    settings_ = settings;
    solver_.SetIterations(settings.iterations);
  }
  void FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) override;
  void ScaleInertia(std::span<const InertiaScale> scales) override;
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows) override;
  void SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) override;
  void Recall(const ContactBuffer& solved) override;
  void SaveState(std::string& bytes) const override { memory_.Save(bytes); }

 private:
  Body& body(EntityRow row) { return *bodies_[Index(row)]; }
  PlacedGeometry& geometry(GeometryRow row);
  ContactMemory::Motion MotionOf(EntityId id) const;
  std::pair<ContactMemory::Key, Placement> Identify(const ContactPair& pair);
  Body* Load(Body& body, const StateArrays& state);
  bool IsDirect(uint32_t number, const ContactBuffer& contacts);
  void SolveIsland(uint32_t number, double step_size, const StateArrays& state, ContactBuffer& contacts,
                   std::span<JointRow> joint_rows);
  void LoadContacts(uint32_t number, const StateArrays& state, ContactBuffer& contacts);
  void LoadRows(uint32_t number, const StateArrays& state, std::span<JointRow> joint_rows);
  void Move(Body& body, double step_size, StateArrays& state);

  std::vector<std::unique_ptr<Body>> bodies_;  // by entity row
  std::vector<PlacedGeometry*> geometries_;    // by geometry row
  ContactSolver solver_;
  ContactMemory memory_;  // its pairs are those of the last Solve()
  uint64_t solve_stamp_ = 0;
  uint64_t island_stamp_ = 0;
  StepperSettings settings_;
  Islands islands_;
  std::vector<EntityRow> scaled_;  // bodies that are harder to turn
};

}  // namespace genphys::bullet_backend

#pragma once
#include <string>
#include <vector>

#include "genphys/backend.h"

namespace genphys::ballistic_backend {

/// Moves each body by the velocity it is given. All it has to know of a body is its centre of mass, for that is what
/// velocity moves; everything else is in the columns.
class World final : public BackendWorld {
 public:
  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows) override;

  // Rows are not read again after their removal until they are added anew.
  void RemoveBody(EntityRow) override {}
  // Solve() moves the rows that it is told, from where the columns say they are.
  void SetActive(std::span<const EntityRow>, bool) override {}
  void WriteState(std::span<const EntityRow>, const StateArrays&) override {}
  void SetStepper(const StepperSettings&) override {}

  void FindPoints(GeometryRow, GeometryRow, std::vector<ContactPoint>&) override {}
  void SaveState(std::string&) const override {}

 private:
  std::vector<Vector3> centers_of_mass_;  // in the frame of the entity, m; by entity row
};

}  // namespace genphys::ballistic_backend

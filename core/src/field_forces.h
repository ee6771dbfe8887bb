#pragma once
#include <vector>

#include "genphys/row_marks.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "spring_forces.h"

namespace genphys {

/// What the force fields of a scene do to its entities at one moment.
class FieldForces {
 public:
  FieldForces(const Scene& scene, const StateArrays& state) : scene_(scene), state_(state) {}

  bool empty() const { return scene_.force_fields.empty(); }

  /// Adds what acts on `rows` (dynamic) over a substep of `h` seconds to `wrenches`, but for drag.
  void Add(const std::vector<EntityRow>& rows, double h, RowValues<Wrench>& wrenches) const;

  /// Takes from a velocity (m/s) and an angular momentum (N*m*s) what drag takes in `h` seconds. `inverse_tensor` is in
  /// world axes.
  void Drag(EntityRow row, double h, const Matrix3& inverse_tensor, Vector3& velocity, Vector3& momentum) const;

 private:
  const SceneEntity& entity(EntityRow row) const { return *scene_.entities[Index(row)]; }
  Vector3 CenterOf(EntityRow row) const;
  bool ActsOn(const ForceField& field, EntityRow row) const;
  SpringEnd EndOf(EntityId id, const Vector3& point) const;
  void AddSprings(double h, RowValues<Wrench>& wrenches) const;

  const Scene& scene_;
  const StateArrays& state_;
};

}  // namespace genphys

#pragma once
#include <span>
#include <vector>

#include "genphys/bounds.h"
#include "genphys/row_marks.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "motion/resistance.h"
#include "motion/spring_forces.h"

namespace genphys {

/// What the force fields of a scene do to its entities at one moment.
class FieldForces {
 public:
  FieldForces(const Scene& scene, const StateArrays& state) : scene_(scene), state_(state) {}

  bool empty() const { return scene_.force_fields.empty(); }

  /// On whom fields may act. Whoever is neither named nor comes into a region is left alone.
  struct Reach {
    bool is_everywhere = false;                     // on all
    std::vector<EntityId> tied;                     // on these ends of springs, null ones among them
    std::vector<std::span<const EntityId>> listed;  // on those whom fields name, ascending; views of these fields
    std::vector<Bounds> regions;                    // on whose centre of mass is in one of them

    void Add(const ForceField& field);
  };
  Reach reach() const;

  /// Adds what acts on `rows` (dynamic) over a substep of `h` seconds to `wrenches`, but for what resists them.
  void Add(const std::vector<EntityRow>& rows, double h, RowValues<Wrench>& wrenches) const;

  /// All that resists an entity where it is. `inverse_tensor`, in world axes, outlives it.
  Resistance ResistanceOf(EntityRow row, const Matrix3& inverse_tensor) const;
  /// Whether a medium is among that.
  bool IsInMedium(EntityRow row) const;

 private:
  // Calls visit(drag, part) for each that acts on the entity, `part` of which is in the medium.
  template <typename Visit>
  void VisitDrag(EntityRow row, Visit visit) const;
  const SceneEntity& entity(EntityRow row) const { return *scene_.entities[Index(row)]; }
  Vector3 CenterOf(EntityRow row) const;
  bool ActsOn(const ForceField& field, EntityRow row) const;
  bool Moves(EntityId id) const;
  SpringEnd EndOf(EntityId id, const Vector3& point) const;
  void AddSprings(double h, RowValues<Wrench>& wrenches) const;

  const Scene& scene_;
  const StateArrays& state_;
};

}  // namespace genphys

#pragma once
#include <memory>

#include "genphys/entity.h"
#include "genphys/ids.h"
#include "genphys/placement.h"

struct dxGeom;

namespace genphys::ode_backend {

struct GeomDeleter {
  void operator()(dxGeom* geom) const;
};
using GeomPtr = std::unique_ptr<dxGeom, GeomDeleter>;

/// One collision geometry as ODE has it: bound to no body and in no space, put where it belongs by us. What is
/// round, or a plane, ODE has thicker by a skin, because it finds no contact across a gap, and bodies that rest on
/// contacts which come and go with the last bit never come to rest.
class PlacedShape {
 public:
  PlacedShape() = default;
  PlacedShape(EntityRow entity, const Geometry& geometry);

  /// Follows the entity, whose frame is at `position`, turned by `orientation`.
  void Place(const Vector3& position, const Quaternion& orientation);

  EntityRow entity() const { return entity_; }
  /// Unique in the entity.
  uint32_t id() const { return id_; }
  const Shape& shape() const { return shape_; }
  /// Null for what ODE does not collide: the shapes of the narrow phase.
  dxGeom* geom() const { return geom_.get(); }
  /// Of the shape's own frame, world.
  const Vector3& position() const { return position_; }
  const Matrix3& rotation() const { return rotation_; }

  /// Where it is, as the narrow phase takes it.
  Placement placement() const { return {position_, rotation_}; }
  /// m, its part of the largest gap across which it is told to touch.
  double reach() const { return reach_; }
  /// m, by how much ODE has it thicker.
  double skin() const { return skin_; }

  bool is_plane() const { return std::holds_alternative<Plane>(shape_); }

 private:
  EntityRow entity_{};
  uint32_t id_ = 0;
  Shape shape_;
  Vector3 position_in_entity_ = Vector3::Zero();
  Matrix3 rotation_in_entity_ = Matrix3::Identity();
  bool is_at_entity_ = true;
  double reach_ = 0;
  double skin_ = 0;
  GeomPtr geom_;
  Vector3 position_ = Vector3::Zero();
  Matrix3 rotation_ = Matrix3::Identity();
};

}  // namespace genphys::ode_backend

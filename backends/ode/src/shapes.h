#pragma once
#include <memory>

#include "genphys/swept_world.h"

struct dxGeom;

namespace genphys::ode_backend {

struct GeomDeleter {
  void operator()(dxGeom* geom) const;
};
using GeomPtr = std::unique_ptr<dxGeom, GeomDeleter>;

/// A collision geometry as ODE has it: bound to no body and in no space, put where it belongs by us. What is round, or
/// a plane, ODE has thicker by a skin, because it finds no contact across a gap, and bodies that rest on contacts which
/// come and go with the last bit never come to rest.
class OdeShape {
 public:
  OdeShape() = default;
  explicit OdeShape(const Shape& shape);

  /// Goes to where the geometry of this shape is now.
  void Follow(const PlacedGeometry& geometry);

  /// Null for what ODE does not collide: the shapes of the narrow phase.
  dxGeom* geom() const { return geom_.get(); }
  /// m, its part of the largest gap across which it is told to touch.
  double reach() const { return reach_; }
  /// m, by how much ODE has it thicker.
  double skin() const { return skin_; }

 private:
  double reach_ = 0;
  double skin_ = 0;
  GeomPtr geom_;
};

}  // namespace genphys::ode_backend

#include "shapes.h"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>

#include "genphys/backend.h"
#include "genphys/bounds.h"

namespace genphys::ode_backend {
namespace {

constexpr dSpaceID kNoSpace = nullptr;

// m, on either side: a pair is told across twice as much.
constexpr double kReachMax = 1e-4;
// Small shapes are told nearer, across this part of their smallest half extent.
constexpr double kReachPart = 1e-3;

dGeomID Create(const Sphere& s, double skin) { return dCreateSphere(kNoSpace, s.radius + skin); }
dGeomID Create(const Box& s, double) {
  return dCreateBox(kNoSpace, 2 * s.half_extents.x(), 2 * s.half_extents.y(), 2 * s.half_extents.z());
}
dGeomID Create(const Capsule& s, double skin) { return dCreateCapsule(kNoSpace, s.radius + skin, 2 * s.half_length); }
dGeomID Create(const Cylinder& s, double) { return dCreateCylinder(kNoSpace, s.radius, 2 * s.half_length); }
dGeomID Create(const Plane& s, double skin) {
  return dCreatePlane(kNoSpace, s.normal.x(), s.normal.y(), s.normal.z(), s.offset + skin);
}
// The narrow phase's.
template <typename Other>
dGeomID Create(const Other&, double) {
  return nullptr;
}

// What has edges would be another shape with a skin, its edges beside where they are. It meets nothing but what has
// one.
bool HasEdges(const Shape& shape) {
  return std::holds_alternative<Box>(shape) || std::holds_alternative<Cylinder>(shape);
}

}  // namespace

void GeomDeleter::operator()(dxGeom* geom) const { dGeomDestroy(geom); }

OdeShape::OdeShape(const Shape& shape)
    : reach_(std::min(kReachMax, kReachPart * SmallestHalfExtent(shape))),
      skin_(HasEdges(shape) ? 0 : reach_ + kReachMax),
      geom_(std::visit([this](const auto& s) { return Create(s, skin_); }, shape)) {}

void OdeShape::Follow(const PlacedGeometry& geometry) {
  if (geom_ == nullptr) return;
  const auto& [position, rotation] = geometry.placement;
  if (const auto* const plane = std::get_if<Plane>(&geometry.shape)) {
    const Vector3 normal = rotation * plane->normal;
    dGeomPlaneSetParams(geom(), normal.x(), normal.y(), normal.z(), plane->offset + normal.dot(position) + skin_);
    return;
  }
  dMatrix3 rows = {};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rows[4 * row + column] = rotation(row, column);
  }
  dGeomSetPosition(geom(), position.x(), position.y(), position.z());
  dGeomSetRotation(geom(), rows);
}

}  // namespace genphys::ode_backend

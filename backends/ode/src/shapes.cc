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
constexpr double kSkinMax = 1e-4;
// Small shapes have a thinner one, of this part of their smallest half extent.
constexpr double kSkinPart = 1e-3;

dGeomID Create(const Sphere& s, double skin) { return dCreateSphere(kNoSpace, s.radius + skin); }
dGeomID Create(const Box& s, double skin) {
  const Vector3 sides = 2 * (s.half_extents.array() + skin);
  return dCreateBox(kNoSpace, sides.x(), sides.y(), sides.z());
}
dGeomID Create(const Capsule& s, double skin) { return dCreateCapsule(kNoSpace, s.radius + skin, 2 * s.half_length); }
dGeomID Create(const Cylinder& s, double skin) {
  return dCreateCylinder(kNoSpace, s.radius + skin, 2 * (s.half_length + skin));
}
dGeomID Create(const Plane& s, double skin) {
  return dCreatePlane(kNoSpace, s.normal.x(), s.normal.y(), s.normal.z(), s.offset + skin);
}
// The narrow phase's.
template <typename Other>
dGeomID Create(const Other&, double) {
  return nullptr;
}

// How far a skin of one metre puts out the surface where its normal is `n`, in the frame of the shape: a box is made
// longer along each axis and a cylinder along its axis and its radius, so at edges it is more than the thickness.
double PutOut(const Sphere&, const Vector3&) { return 1; }
double PutOut(const Box&, const Vector3& n) { return n.cwiseAbs().sum(); }
double PutOut(const Capsule&, const Vector3&) { return 1; }
double PutOut(const Cylinder&, const Vector3& n) { return std::abs(n.z()) + n.head<2>().norm(); }
template <typename Other>
double PutOut(const Other&, const Vector3&) {
  return 1;
}

}  // namespace

void GeomDeleter::operator()(dxGeom* geom) const { dGeomDestroy(geom); }

PlacedShape::PlacedShape(EntityRow entity, const Geometry& geometry)
    : entity_(entity),
      id_(geometry.id),
      shape_(geometry.shape),
      position_in_entity_(geometry.pose_in_entity.position),
      rotation_in_entity_(geometry.pose_in_entity.orientation.toRotationMatrix()),
      is_at_entity_(geometry.pose_in_entity == Pose{}),
      skin_(std::min(kSkinMax, kSkinPart * SmallestHalfExtent(shape_))),
      geom_(std::visit([this](const auto& s) { return Create(s, skin_); }, shape_)) {}

void PlacedShape::Place(const Vector3& position, const Quaternion& orientation) {
  position_ = position;
  rotation_ = orientation.toRotationMatrix();
  if (!is_at_entity_) {
    position_ += rotation_ * position_in_entity_;
    rotation_ *= rotation_in_entity_;
  }
  if (is_plane()) {
    const Plane& plane = std::get<Plane>(shape_);
    const Vector3 normal = rotation_ * plane.normal;
    dGeomPlaneSetParams(geom(), normal.x(), normal.y(), normal.z(), plane.offset + normal.dot(position_) + skin_);
    return;
  }
  if (geom_ == nullptr) return;
  dMatrix3 rows = {};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rows[4 * row + column] = rotation_(row, column);
  }
  dGeomSetPosition(geom(), position_.x(), position_.y(), position_.z());
  dGeomSetRotation(geom(), rows);
}

double PlacedShape::Skin(const Vector3& normal) const {
  const Vector3 in_shape = rotation_.transpose() * normal;
  return skin_ * std::visit([&](const auto& s) { return PutOut(s, in_shape); }, shape_);
}

}  // namespace genphys::ode_backend

#include "body.h"

#include <Eigen/Eigenvalues>

#include "absl/strings/str_cat.h"
#include "convert.h"

namespace genphys::bullet_backend {
namespace {

// Bullet takes principal moments only, so that any other tensor is given in a frame turned to its axes.
void FindPrincipalAxes(const Matrix3& tensor, Vector3& moments, Matrix3& axes) {
  moments = tensor.diagonal();
  if (tensor.isDiagonal(0)) return;
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(tensor);
  moments = solver.eigenvalues();
  axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
}

}  // namespace

Body::Body(const BodyDesc& desc, const StateArrays& state)
    : row(desc.row), id(desc.id), motion_type(desc.body.motion_type) {
  geometries.reserve(desc.body.geometries.size());
  for (size_t i = 0; i < desc.body.geometries.size(); ++i) {
    const Geometry& geometry = desc.body.geometries[i];
    geometries.push_back({.body = this,
                          .row = desc.geometries[i],
                          .id = geometry.id,
                          .pose_in_entity = geometry.pose_in_entity,
                          .shape = geometry.shape});
  }
  if (motion_type == MotionType::kDynamic) {
    center_of_mass = desc.mass.center_of_mass;
    FindPrincipalAxes(desc.mass.tensor, moments, principal_axes);
    rigid = std::make_unique<btRigidBody>(desc.mass.mass, nullptr, nullptr, ToBullet(moments));
  } else if (motion_type == MotionType::kKinematic) {
    rigid = std::make_unique<btRigidBody>(0.0, nullptr, nullptr);
    rigid->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  }
  if (rigid) {
    rigid->setUserPointer(this);
    // The layer integrates the gyroscopic torque; Bullet would do it on its own by default.
    rigid->setFlags(0);
  }
  TakePose(state);
}

void Body::TakePose(const StateArrays& state) {
  const auto column = Index(row);
  if (!state.positions.col(column).allFinite() || !state.orientations.col(column).allFinite()) {
    throw EngineFault(absl::StrCat("the pose of entity ", id.packed(), " is not finite"));
  }
  pose = state.pose(row);
  is_moved = true;
}

void Body::PlaceGeometries() {
  const Placement entity = ToPlacement(pose);
  for (PlacedGeometry& geometry : geometries) {
    geometry.placement.position = entity.Transform(geometry.pose_in_entity.position);
    geometry.placement.rotation = entity.rotation * geometry.pose_in_entity.orientation.toRotationMatrix();
  }
}

void Body::LoadRigid(const StateArrays& state) {
  const Placement entity = ToPlacement(pose);
  const Placement center{entity.Transform(center_of_mass), entity.rotation * principal_axes};
  if (motion_type == MotionType::kDynamic) {
    rigid->setInvInertiaDiagLocal(ToBullet((inertia_factor * moments).cwiseInverse()));
  }
  rigid->setWorldTransform(ToTransform(center));
  rigid->updateInertiaTensor();
  rigid->setLinearVelocity(ToBullet(state.linear_velocities.col(Index(row))));
  rigid->setAngularVelocity(ToBullet(state.angular_velocities.col(Index(row))));
}

}  // namespace genphys::bullet_backend

#pragma once
#include <span>

#include "genphys/entity.h"
#include "genphys/math.h"
#include "genphys/status.h"

namespace genphys {

/// Mass, centre of mass in the frame of the entity, and tensor about that centre in the axes of the entity's frame.
struct MassProperties {
  double mass = 0;                           // kg
  Vector3 center_of_mass = Vector3::Zero();  // m
  Matrix3 tensor = Matrix3::Zero();          // kg*m^2
  Matrix3 inverse_tensor = Matrix3::Zero();  // 1/(kg*m^2)
  bool spherical = false;                    // all principal moments equal: rotation is uniform without torque
};

/// Volume of `shape` in m^3; planes, meshes and heightfields have none.
double Volume(const Shape& shape);

/// Centre of mass of `shape` filled uniformly, in its own frame, m.
Vector3 CenterOfMass(const Shape& shape);

/// Tensor of `shape` about its centre of mass for unit density (kg*m^2 per kg/m^3): by closed form, of a hull by exact
/// integration.
Matrix3 UnitDensityTensor(const Shape& shape);

/// Mass properties of a dynamic body: what `body.inertia` gives, the rest from shapes and (filled) densities.
/// Refuses a tensor that no distribution of mass has, and a body without volume that gives no mass.
Result<MassProperties> ComputeMassProperties(const RigidBody& body);

/// OK if `tensor` is symmetric, positive definite and obeys the triangle inequality of principal moments.
Status CheckTensor(const Matrix3& tensor, std::string_view field);

}  // namespace genphys

#include "enums.h"
#include "genphys/wire/encode.h"
#include "material_fields.h"
#include "shape_message.h"
#include "values.h"

namespace genphys {
namespace {

void EncodeGeometry(const Geometry& geometry, v1::Geometry* out) {
  out->set_id(geometry.id);
  EncodeShape(geometry.shape, out->mutable_shape());
  EncodePose(geometry.pose_in_entity, out->mutable_pose_in_entity());
  if (geometry.material != Material{}) EncodeMaterial(geometry.material, out->mutable_material());
  out->set_category_bits(geometry.category_bits);
  out->set_collides_with_bits(geometry.collides_with_bits);
  out->set_is_sensor(geometry.is_sensor);
  out->set_collision_space(geometry.collision_space);
  EncodeVector(geometry.surface_velocity, out->mutable_surface_velocity());
}

void EncodeInertia(const InertiaDesc& inertia, v1::RigidBody* body) {
  if (!inertia.mass && !inertia.center_of_mass && !inertia.tensor) return;
  v1::Inertia* out = body->mutable_inertia();
  if (inertia.mass) out->set_mass(*inertia.mass);
  if (inertia.center_of_mass) EncodeVector(*inertia.center_of_mass, out->mutable_center_of_mass());
  if (!inertia.tensor) return;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) out->add_tensor((*inertia.tensor)(row, column));
  }
}

void EncodeLocks(const LockedAxes& axes, v1::LockedAxes* out) {
  out->set_linear_x(axes.linear[0]);
  out->set_linear_y(axes.linear[1]);
  out->set_linear_z(axes.linear[2]);
  out->set_angular_x(axes.angular[0]);
  out->set_angular_y(axes.angular[1]);
  out->set_angular_z(axes.angular[2]);
}

void EncodeBody(const RigidBody& body, v1::RigidBody* out) {
  out->set_motion_type(EncodeMotionType(body.motion_type));
  out->mutable_geometries()->Reserve(static_cast<int>(body.geometries.size()));
  for (const Geometry& geometry : body.geometries) EncodeGeometry(geometry, out->add_geometries());
  EncodeInertia(body.inertia, out);
  if (body.auto_disable != AutoDisable{}) EncodeAutoDisable(body.auto_disable, out->mutable_auto_disable());
  if (body.error_correction.any()) EncodeErrorCorrection(body.error_correction, out->mutable_error_correction());
  EncodeVector(body.linear_velocity, out->mutable_linear_velocity());
  EncodeVector(body.angular_velocity, out->mutable_angular_velocity());
  out->set_linear_damping(body.linear_damping);
  out->set_angular_damping(body.angular_damping);
  out->set_gravity_scale(body.gravity_scale);
  if (body.linear_speed_max) out->set_linear_speed_max(*body.linear_speed_max);
  if (body.angular_speed_max) out->set_angular_speed_max(*body.angular_speed_max);
  for (const EntityId id : body.ignored_entities) out->add_ignored_entity_ids(id.packed());
  if (body.locked_axes.any()) EncodeLocks(body.locked_axes, out->mutable_locked_axes());
}

}  // namespace

void EncodeEntity(EntityId id, const EntityDesc& desc, v1::Entity* out) {
  out->set_id(id.packed());
  out->set_display_name(desc.display_name);
  EncodePose(desc.pose, out->mutable_pose());
  if (desc.rigid_body) EncodeBody(*desc.rigid_body, out->mutable_rigid_body());
  if (!desc.visual) return;
  out->mutable_visual()->set_uri(desc.visual->uri);
  out->mutable_visual()->set_media_type(desc.visual->media_type);
  out->mutable_visual()->set_data(desc.visual->data);
}

}  // namespace genphys

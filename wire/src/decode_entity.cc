#include <string>
#include <utility>

#include "enums.h"
#include "genphys/wire/decode.h"
#include "material_fields.h"
#include "shape_message.h"
#include "values.h"

namespace genphys {
namespace {

Result<Geometry> DecodeGeometry(const v1::Geometry& geometry) {
  Result<Shape> shape = DecodeShape(geometry.shape());
  if (!shape.ok()) return WithFieldPrefix(shape.status(), "shape");
  Geometry decoded{.id = geometry.id(),
                   .shape = *shape,
                   .pose_in_entity = DecodePose(geometry.pose_in_entity()),
                   .material = DecodeMaterial(geometry.material()),
                   .is_sensor = geometry.is_sensor(),
                   .collision_space = geometry.collision_space(),
                   .surface_velocity = DecodeVector(geometry.surface_velocity())};
  if (geometry.has_category_bits()) decoded.category_bits = geometry.category_bits();
  if (geometry.has_collides_with_bits()) decoded.collides_with_bits = geometry.collides_with_bits();
  return decoded;
}

InertiaDesc DecodeInertia(const v1::Inertia& inertia) {
  InertiaDesc decoded;
  if (inertia.has_mass()) decoded.mass = inertia.mass();
  if (inertia.has_center_of_mass()) decoded.center_of_mass = DecodeVector(inertia.center_of_mass());
  if (inertia.tensor_size() == 6) {
    const auto& t = inertia.tensor();
    decoded.tensor = Matrix3{{t[0], t[1], t[2]}, {t[1], t[3], t[4]}, {t[2], t[4], t[5]}};
  }
  return decoded;
}

LockedAxes DecodeLocks(const v1::LockedAxes& axes) {
  return {{axes.linear_x(), axes.linear_y(), axes.linear_z()}, {axes.angular_x(), axes.angular_y(), axes.angular_z()}};
}

Result<RigidBody> DecodeBody(const v1::RigidBody& body) {
  RigidBody decoded{.motion_type = DecodeMotionType(body.motion_type()),
                    .inertia = DecodeInertia(body.inertia()),
                    .auto_disable = DecodeAutoDisable(body.auto_disable()),
                    .error_correction = DecodeErrorCorrection(body.error_correction()),
                    .linear_velocity = DecodeVector(body.linear_velocity()),
                    .angular_velocity = DecodeVector(body.angular_velocity()),
                    .linear_damping = body.linear_damping(),
                    .angular_damping = body.angular_damping(),
                    .locked_axes = DecodeLocks(body.locked_axes())};
  if (body.has_gravity_scale()) decoded.gravity_scale = body.gravity_scale();
  if (body.has_linear_speed_max()) decoded.linear_speed_max = body.linear_speed_max();
  if (body.has_angular_speed_max()) decoded.angular_speed_max = body.angular_speed_max();
  for (const uint64_t id : body.ignored_entity_ids()) decoded.ignored_entities.push_back(EntityId::FromPacked(id));
  decoded.geometries.reserve(static_cast<size_t>(body.geometries_size()));
  for (int i = 0; i < body.geometries_size(); ++i) {
    Result<Geometry> geometry = DecodeGeometry(body.geometries(i));
    if (!geometry.ok()) return WithFieldPrefix(geometry.status(), "geometries[" + std::to_string(i) + "]");
    decoded.geometries.push_back(*std::move(geometry));
  }
  return decoded;
}

}  // namespace

Result<EntityDesc> DecodeEntity(const v1::Entity& entity) {
  EntityDesc decoded{.display_name = entity.display_name(), .pose = DecodePose(entity.pose())};
  if (entity.has_rigid_body()) {
    Result<RigidBody> body = DecodeBody(entity.rigid_body());
    if (!body.ok()) return WithFieldPrefix(body.status(), "rigid_body");
    decoded.rigid_body = *std::move(body);
  }
  if (entity.has_visual()) {
    const v1::Visual& visual = entity.visual();
    decoded.visual = Visual{visual.uri(), visual.media_type(), visual.data()};
  }
  return decoded;
}

Result<CreateEntity> DecodeCreate(const v1::Entity& entity) {
  GENPHYS_RETURN_IF_ERROR(CheckNoId(entity.id()));
  Result<EntityDesc> desc = DecodeEntity(entity);
  if (!desc.ok()) return desc.status();
  return CreateEntity{*std::move(desc)};
}

}  // namespace genphys

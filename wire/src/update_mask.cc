#include "update_mask.h"

#include <array>
#include <string>
#include <string_view>

#include "values.h"

namespace genphys {
namespace {

struct FieldPath {
  std::string_view path;
  EntityField field;
};

constexpr std::array kPaths{
    FieldPath{"display_name", EntityField::kDisplayName},
    FieldPath{"pose", EntityField::kPose},
    FieldPath{"visual", EntityField::kVisual},
    FieldPath{"rigid_body", EntityField::kRigidBody},
    FieldPath{"rigid_body.motion_type", EntityField::kMotionType},
    FieldPath{"rigid_body.geometries", EntityField::kGeometries},
    FieldPath{"rigid_body.inertia", EntityField::kInertia},
    FieldPath{"rigid_body.auto_disable", EntityField::kAutoDisable},
    FieldPath{"rigid_body.linear_velocity", EntityField::kLinearVelocity},
    FieldPath{"rigid_body.angular_velocity", EntityField::kAngularVelocity},
    FieldPath{"rigid_body.linear_damping", EntityField::kLinearDamping},
    FieldPath{"rigid_body.angular_damping", EntityField::kAngularDamping},
    FieldPath{"rigid_body.gravity_scale", EntityField::kGravityScale},
    FieldPath{"rigid_body.linear_speed_max", EntityField::kLinearSpeedMax},
    FieldPath{"rigid_body.angular_speed_max", EntityField::kAngularSpeedMax},
    FieldPath{"rigid_body.locked_axes", EntityField::kLockedAxes},
    FieldPath{"rigid_body.error_correction", EntityField::kErrorCorrection},
    FieldPath{"rigid_body.ignored_entity_ids", EntityField::kIgnoredEntities},
};

bool IsInside(std::string_view path, std::string_view whole) {
  return path.size() > whole.size() && path.starts_with(whole) && path[whole.size()] == '.';
}

// Where in the mask it stands is told by whoever goes through that.
Result<EntityField> DecodePath(const std::string& path) {
  // The longest path that holds a deeper one is the part to name instead.
  std::string_view part;
  for (const FieldPath& known : kPaths) {
    if (path == known.path) return known.field;
    if (IsInside(path, known.path)) part = known.path;
  }
  if (part.empty() || part == "rigid_body") {
    std::string all;
    for (const FieldPath& known : kPaths) all.append(all.empty() ? "" : ", ").append(known.path);
    return Refuse(Reason::kInvalidValue, "", "\"" + path + "\" names no field that an update can change: " + all);
  }
  return Refuse(Reason::kInvalidValue, "",
                "\"" + path + "\" cannot change alone; name \"" + std::string(part) + "\" and set all of it");
}

}  // namespace

std::string PlaceInMask(int index) { return "update_mask.paths[" + std::to_string(index) + "]"; }

Result<EntityFields> DecodeMask(const google::protobuf::FieldMask& mask) {
  EntityFields fields;
  for (int i = 0; i < mask.paths_size(); ++i) {
    const Result<EntityField> field = DecodePath(mask.paths(i));
    if (!field.ok()) return WithFieldPrefix(field.status(), PlaceInMask(i));
    fields.Add(*field);
  }
  return fields;
}

EntityFields PopulatedFields(const v1::Entity& entity) {
  EntityFields fields;
  const auto add_if = [&fields](bool populated, EntityField field) {
    if (populated) fields.Add(field);
  };
  if (entity.has_rigid_body()) {
    const v1::RigidBody& body = entity.rigid_body();
    add_if(body.motion_type() != v1::MOTION_TYPE_UNSPECIFIED, EntityField::kMotionType);
    add_if(body.geometries_size() > 0, EntityField::kGeometries);
    add_if(body.has_inertia(), EntityField::kInertia);
    add_if(body.has_auto_disable(), EntityField::kAutoDisable);
    add_if(body.has_linear_velocity(), EntityField::kLinearVelocity);
    add_if(body.has_angular_velocity(), EntityField::kAngularVelocity);
    add_if(body.has_linear_damping(), EntityField::kLinearDamping);
    add_if(body.has_angular_damping(), EntityField::kAngularDamping);
    add_if(body.has_gravity_scale(), EntityField::kGravityScale);
    add_if(body.has_linear_speed_max(), EntityField::kLinearSpeedMax);
    add_if(body.has_angular_speed_max(), EntityField::kAngularSpeedMax);
    add_if(body.has_locked_axes(), EntityField::kLockedAxes);
    add_if(body.has_error_correction(), EntityField::kErrorCorrection);
    add_if(body.ignored_entity_ids_size() > 0, EntityField::kIgnoredEntities);
    add_if(fields.bits == 0, EntityField::kRigidBody);
  }
  add_if(!entity.display_name().empty(), EntityField::kDisplayName);
  add_if(entity.has_pose(), EntityField::kPose);
  add_if(entity.has_visual(), EntityField::kVisual);
  return fields;
}

void EncodeMask(EntityFields fields, google::protobuf::FieldMask* out) {
  for (const FieldPath& known : kPaths) {
    if (fields.Has(known.field)) out->add_paths(known.path.data(), known.path.size());
  }
}

}  // namespace genphys

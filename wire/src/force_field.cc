#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "values.h"

namespace genphys {
namespace {

DragField DecodeDrag(const v1::DragField& drag) {
  return {drag.linear(), drag.quadratic(), drag.angular(), DecodeVector(drag.medium_velocity())};
}

void EncodeDrag(const DragField& drag, v1::DragField* out) {
  out->set_linear(drag.linear);
  out->set_quadratic(drag.quadratic);
  out->set_angular(drag.angular);
  EncodeVector(drag.medium_velocity, out->mutable_medium_velocity());
}

SpringField DecodeSpring(const v1::SpringField& spring) {
  return {.a = EntityId::FromPacked(spring.entity_a()),
          .b = EntityId::FromPacked(spring.entity_b()),
          .point_in_a = DecodeVector(spring.point_in_a()),
          .point_in_b = DecodeVector(spring.point_in_b()),
          .rest_length = spring.rest_length(),
          .stiffness = spring.stiffness(),
          .damping = spring.damping()};
}

PointGravityField DecodePointGravity(const v1::PointGravityField& gravity) {
  PointGravityField decoded{.center = DecodeVector(gravity.center()), .strength = gravity.strength()};
  if (gravity.has_softening()) decoded.softening = gravity.softening();
  return decoded;
}

BuoyancyField DecodeBuoyancy(const v1::BuoyancyField& fluid) {
  BuoyancyField decoded{.surface_offset = fluid.surface_offset(), .drag = DecodeDrag(fluid.drag())};
  if (fluid.has_surface_normal()) decoded.surface_normal = DecodeVector(fluid.surface_normal());
  if (fluid.has_fluid_density()) decoded.fluid_density = fluid.fluid_density();
  return decoded;
}

Result<ForceFieldKind> DecodeKind(const v1::ForceField& field) {
  switch (field.kind_case()) {
    case v1::ForceField::kUniform:
      return UniformField{DecodeVector(field.uniform().force()), DecodeVector(field.uniform().acceleration())};
    case v1::ForceField::kDrag:
      return DecodeDrag(field.drag());
    case v1::ForceField::kSpring:
      return DecodeSpring(field.spring());
    case v1::ForceField::kPointGravity:
      return DecodePointGravity(field.point_gravity());
    case v1::ForceField::kBuoyancy:
      return DecodeBuoyancy(field.buoyancy());
    case v1::ForceField::KIND_NOT_SET:
      break;
  }
  return Refuse(Reason::kMissingField, "kind", "a force field says what it does");
}

struct KindEncoder {
  v1::ForceField* out;

  void operator()(const UniformField& field) const {
    EncodeVector(field.force, out->mutable_uniform()->mutable_force());
    EncodeVector(field.acceleration, out->mutable_uniform()->mutable_acceleration());
  }
  void operator()(const DragField& field) const { EncodeDrag(field, out->mutable_drag()); }
  void operator()(const SpringField& field) const {
    v1::SpringField* const spring = out->mutable_spring();
    spring->set_entity_a(field.a.packed());
    spring->set_entity_b(field.b.packed());
    EncodeVector(field.point_in_a, spring->mutable_point_in_a());
    EncodeVector(field.point_in_b, spring->mutable_point_in_b());
    spring->set_rest_length(field.rest_length);
    spring->set_stiffness(field.stiffness);
    spring->set_damping(field.damping);
  }
  void operator()(const PointGravityField& field) const {
    EncodeVector(field.center, out->mutable_point_gravity()->mutable_center());
    out->mutable_point_gravity()->set_strength(field.strength);
    out->mutable_point_gravity()->set_softening(field.softening);
  }
  void operator()(const BuoyancyField& field) const {
    v1::BuoyancyField* const fluid = out->mutable_buoyancy();
    EncodeVector(field.surface_normal, fluid->mutable_surface_normal());
    fluid->set_surface_offset(field.surface_offset);
    fluid->set_fluid_density(field.fluid_density);
    EncodeDrag(field.drag, fluid->mutable_drag());
  }
};

}  // namespace

Result<ForceField> DecodeForceField(const v1::ForceField& field) {
  Result<ForceFieldKind> kind = DecodeKind(field);
  if (!kind.ok()) return kind.status();
  ForceField decoded{.kind = *std::move(kind)};
  for (const uint64_t id : field.entity_ids()) decoded.entities.push_back(EntityId::FromPacked(id));
  if (field.has_region())
    decoded.region = Region{DecodeVector(field.region().corner()), DecodeVector(field.region().opposite_corner())};
  return decoded;
}

void EncodeForceField(ForceFieldId id, const ForceField& field, v1::ForceField* out) {
  out->set_id(id);
  for (const EntityId entity : field.entities) out->add_entity_ids(entity.packed());
  if (field.region) {
    EncodeVector(field.region->corner, out->mutable_region()->mutable_corner());
    EncodeVector(field.region->opposite_corner, out->mutable_region()->mutable_opposite_corner());
  }
  std::visit(KindEncoder{out}, field.kind);
}

}  // namespace genphys

#include "genphys/limits.h"
#include "model/cat.h"
#include "model/validate.h"

namespace genphys {
namespace {

Status CheckDrag(const DragField& drag, std::string_view field) {
  GENPHYS_RETURN_IF_ERROR(CheckNumber(drag.linear, 0, Limits::kDragMax, Cat(field, ".linear")));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(drag.quadratic, 0, Limits::kDragMax, Cat(field, ".quadratic")));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(drag.angular, 0, Limits::kDragMax, Cat(field, ".angular")));
  return CheckVector(drag.medium_velocity, Limits::kSpeedMax, Cat(field, ".medium_velocity"));
}

struct KindCheck {
  Status operator()(const UniformField& field) const {
    GENPHYS_RETURN_IF_ERROR(CheckVector(field.force, Limits::kForceMax, "uniform.force"));
    return CheckVector(field.acceleration, Limits::kGravityMax, "uniform.acceleration");
  }
  Status operator()(const DragField& field) const { return CheckDrag(field, "drag"); }
  Status operator()(const SpringField& field) const {
    GENPHYS_RETURN_IF_ERROR(CheckVector(field.point_in_a, Limits::kPositionMax, "spring.point_in_a"));
    GENPHYS_RETURN_IF_ERROR(CheckVector(field.point_in_b, Limits::kPositionMax, "spring.point_in_b"));
    GENPHYS_RETURN_IF_ERROR(CheckNumber(field.rest_length, 0, Limits::kPositionMax, "spring.rest_length"));
    GENPHYS_RETURN_IF_ERROR(CheckNumber(field.stiffness, 0, Limits::kStiffnessMax, "spring.stiffness"));
    return CheckNumber(field.damping, 0, Limits::kDragMax, "spring.damping");
  }
  Status operator()(const PointGravityField& field) const {
    GENPHYS_RETURN_IF_ERROR(CheckVector(field.center, Limits::kPositionMax, "point_gravity.center"));
    GENPHYS_RETURN_IF_ERROR(
        CheckNumber(field.strength, -Limits::kPointGravityMax, Limits::kPointGravityMax, "point_gravity.strength"));
    return CheckNumber(field.softening, Limits::kSizeMin, Limits::kPositionMax, "point_gravity.softening");
  }
  Status operator()(const BuoyancyField& field) const {
    GENPHYS_RETURN_IF_ERROR(CheckVector(field.surface_normal, 2, "buoyancy.surface_normal"));
    if (std::abs(field.surface_normal.norm() - 1) > Limits::kUnitLengthTolerance) {
      return Refuse(Reason::kNotUnitLength, "buoyancy.surface_normal", "a normal has length 1");
    }
    GENPHYS_RETURN_IF_ERROR(
        CheckNumber(field.surface_offset, -Limits::kPositionMax, Limits::kPositionMax, "buoyancy.surface_offset"));
    GENPHYS_RETURN_IF_ERROR(CheckNumber(field.fluid_density, 0, Limits::kDensityMax, "buoyancy.fluid_density"));
    return CheckDrag(field.drag, "buoyancy.drag");
  }
};

}  // namespace

Status CheckForceField(const ForceField& field) {
  GENPHYS_RETURN_IF_ERROR(std::visit(KindCheck{}, field.kind));
  if (!field.region) return absl::OkStatus();
  GENPHYS_RETURN_IF_ERROR(CheckVector(field.region->corner, Limits::kPositionMax, "region.corner"));
  return CheckVector(field.region->opposite_corner, Limits::kPositionMax, "region.opposite_corner");
}

}  // namespace genphys

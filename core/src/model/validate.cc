#include "model/validate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "genphys/limits.h"
#include "model/cat.h"

namespace genphys {
namespace {

Status CheckOptional(const std::optional<double>& value, double min, double max, std::string_view field) {
  return value ? CheckNumber(*value, min, max, field) : absl::OkStatus();
}

Status CheckSize(double value, std::string_view field) {
  return CheckNumber(value, Limits::kSizeMin, Limits::kSizeMax, field);
}

struct ShapeCheck {
  Status operator()(const Sphere& s) const { return CheckSize(s.radius, "sphere.radius"); }
  Status operator()(const Box& b) const {
    GENPHYS_RETURN_IF_ERROR(CheckSize(b.half_extents.x(), "box.half_extents.x"));
    GENPHYS_RETURN_IF_ERROR(CheckSize(b.half_extents.y(), "box.half_extents.y"));
    return CheckSize(b.half_extents.z(), "box.half_extents.z");
  }
  Status operator()(const Capsule& c) const {
    GENPHYS_RETURN_IF_ERROR(CheckSize(c.radius, "capsule.radius"));
    return CheckSize(c.half_length, "capsule.half_length");
  }
  Status operator()(const Cylinder& c) const {
    GENPHYS_RETURN_IF_ERROR(CheckSize(c.radius, "cylinder.radius"));
    return CheckSize(c.half_length, "cylinder.half_length");
  }
  Status operator()(const Plane& p) const {
    GENPHYS_RETURN_IF_ERROR(CheckVector(p.normal, 2, "plane.normal"));
    if (std::abs(p.normal.norm() - 1) > Limits::kUnitLengthTolerance) {
      return Refuse(Reason::kNotUnitLength, "plane.normal", "a normal has length 1");
    }
    return CheckNumber(p.offset, -Limits::kPositionMax, Limits::kPositionMax, "plane.offset");
  }
  Status operator()(const Cone& c) const {
    GENPHYS_RETURN_IF_ERROR(CheckSize(c.radius, "cone.radius"));
    return CheckSize(c.half_length, "cone.half_length");
  }
  Status operator()(const Ellipsoid& e) const {
    GENPHYS_RETURN_IF_ERROR(CheckSize(e.semi_axes.x(), "ellipsoid.semi_axes.x"));
    GENPHYS_RETURN_IF_ERROR(CheckSize(e.semi_axes.y(), "ellipsoid.semi_axes.y"));
    return CheckSize(e.semi_axes.z(), "ellipsoid.semi_axes.z");
  }
  // Whoever made the data has checked it.
  Status operator()(const ConvexHull& h) const { return CheckMade(h.data != nullptr, "convex_hull.vertices"); }
  Status operator()(const TriangleMesh& m) const { return CheckMade(m.data != nullptr, "triangle_mesh.vertices"); }
  Status operator()(const Heightfield& h) const { return CheckMade(h.data != nullptr, "heightfield.heights"); }

  static Status CheckMade(bool is_made, std::string_view field) {
    return is_made ? absl::OkStatus() : Refuse(Reason::kMissingField, field, "the shape has no data");
  }
};

Status CheckGeometry(const Geometry& geometry, MotionType motion) {
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckShape(geometry.shape), "shape"));
  if (std::holds_alternative<Plane>(geometry.shape) && motion != MotionType::kStatic) {
    return Refuse(Reason::kInvalidValue, "shape.plane", "only a static entity may have a plane");
  }
  GENPHYS_RETURN_IF_ERROR(CheckPose(geometry.pose_in_entity, "pose_in_entity"));
  GENPHYS_RETURN_IF_ERROR(CheckVector(geometry.surface_velocity, Limits::kSpeedMax, "surface_velocity"));
  return WithFieldPrefix(CheckMaterial(geometry.material), "material");
}

Status CheckGeometries(const RigidBody& body) {
  if (body.geometries.size() > Limits::kGeometriesMax) {
    return Refuse(Reason::kOutOfRange, "geometries", Cat("at most ", Limits::kGeometriesMax, " geometries"));
  }
  for (size_t i = 0; i < body.geometries.size(); ++i) {
    const Geometry& geometry = body.geometries[i];
    GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckGeometry(geometry, body.motion_type), Cat("geometries[", i, "]")));
    const auto same_id = [&](const Geometry& other) { return other.id == geometry.id; };
    if (geometry.id != 0 && std::any_of(body.geometries.begin(), body.geometries.begin() + i, same_id)) {
      return Refuse(Reason::kInvalidValue, Cat("geometries[", i, "].id"), "two geometries have the same id");
    }
  }
  return absl::OkStatus();
}

Status CheckInertia(const InertiaDesc& inertia) {
  GENPHYS_RETURN_IF_ERROR(CheckOptional(inertia.mass, Limits::kMassMin, Limits::kMassMax, "mass"));
  if (inertia.center_of_mass) {
    GENPHYS_RETURN_IF_ERROR(CheckVector(*inertia.center_of_mass, Limits::kSizeMax, "center_of_mass"));
  }
  if (!inertia.tensor) return absl::OkStatus();
  for (Eigen::Index i = 0; i < 9; ++i) {
    GENPHYS_RETURN_IF_ERROR(
        CheckNumber(inertia.tensor->data()[i], -Limits::kInertiaMax, Limits::kInertiaMax, "tensor"));
  }
  return CheckTensor(*inertia.tensor, "tensor");
}

Status CheckBody(const RigidBody& body) {
  GENPHYS_RETURN_IF_ERROR(CheckGeometries(body));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckInertia(body.inertia), "inertia"));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckAutoDisable(body.auto_disable), "auto_disable"));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckErrorCorrection(body.error_correction), "error_correction"));
  GENPHYS_RETURN_IF_ERROR(CheckVector(body.linear_velocity, Limits::kSpeedMax, "linear_velocity"));
  GENPHYS_RETURN_IF_ERROR(CheckVector(body.angular_velocity, Limits::kSpinMax, "angular_velocity"));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(body.linear_damping, 0, Limits::kDampingMax, "linear_damping"));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(body.angular_damping, 0, Limits::kDampingMax, "angular_damping"));
  GENPHYS_RETURN_IF_ERROR(
      CheckNumber(body.gravity_scale, -Limits::kGravityScaleMax, Limits::kGravityScaleMax, "gravity_scale"));
  GENPHYS_RETURN_IF_ERROR(CheckOptional(body.linear_speed_max, 0, Limits::kSpeedMax, "linear_speed_max"));
  GENPHYS_RETURN_IF_ERROR(CheckOptional(body.angular_speed_max, 0, Limits::kSpinMax, "angular_speed_max"));
  if (body.motion_type != MotionType::kStatic) return absl::OkStatus();
  const auto refuse = [](std::string_view field) {
    return Refuse(Reason::kInvalidValue, field, "a static entity has no velocity");
  };
  if (!body.linear_velocity.isZero(0)) return refuse("linear_velocity");
  return body.angular_velocity.isZero(0) ? absl::OkStatus() : refuse("angular_velocity");
}

void NumberGeometries(std::vector<Geometry>& geometries) {
  uint32_t next = 1;
  for (Geometry& geometry : geometries) {
    if (geometry.id != 0) continue;
    const auto taken = [&](const Geometry& other) { return other.id == next; };
    while (std::any_of(geometries.begin(), geometries.end(), taken)) ++next;
    geometry.id = next;
  }
}

}  // namespace

Status CheckNumber(double value, double min, double max, std::string_view field) {
  if (!std::isfinite(value)) return Refuse(Reason::kNotFinite, field, Cat(field, " is not a finite number"));
  if (value >= min && value <= max) return absl::OkStatus();
  return Refuse(Reason::kOutOfRange, field, Cat(field, " is ", value, ", outside ", min, " .. ", max));
}

Status CheckVector(const Vector3& value, double bound, std::string_view field) {
  static constexpr std::array<std::string_view, 3> kAxes{".x", ".y", ".z"};
  for (int i = 0; i < 3; ++i) {
    if (std::abs(value[i]) <= bound) continue;  // false for NaN too
    return CheckNumber(value[i], -bound, bound, Cat(field, kAxes[static_cast<size_t>(i)]));
  }
  return absl::OkStatus();
}

Status CheckOrientation(const Quaternion& value, std::string_view field) {
  if (!value.coeffs().allFinite()) return Refuse(Reason::kNotFinite, field, Cat(field, " is not finite"));
  if (std::abs(value.norm() - 1) <= Limits::kUnitLengthTolerance) return absl::OkStatus();
  return Refuse(Reason::kNotUnitLength, field, Cat(field, " is not a unit quaternion"));
}

Status CheckPose(const Pose& pose, std::string_view field) {
  GENPHYS_RETURN_IF_ERROR(CheckVector(pose.position, Limits::kPositionMax, Cat(field, ".position")));
  return CheckOrientation(pose.orientation, Cat(field, ".orientation"));
}

Status CheckStepper(const StepperDesc& stepper) {
  GENPHYS_RETURN_IF_ERROR(
      CheckNumber(stepper.step_size, Limits::kStepSizeMin, Limits::kStepSizeMax, "step_size_seconds"));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(stepper.substeps.value_or(1), 1, Limits::kSubstepsMax, "substeps"));
  return CheckNumber(stepper.iterations.value_or(1), 1, Limits::kIterationsMax, "iterations");
}

Status CheckMaterial(const Material& material) {
  GENPHYS_RETURN_IF_ERROR(CheckOptional(material.friction, 0, Limits::kFrictionMax, "friction"));
  GENPHYS_RETURN_IF_ERROR(CheckOptional(material.kinetic_friction, 0, Limits::kFrictionMax, "kinetic_friction"));
  GENPHYS_RETURN_IF_ERROR(CheckOptional(material.restitution, 0, 1, "restitution"));
  GENPHYS_RETURN_IF_ERROR(CheckOptional(material.rolling_friction, 0, Limits::kFrictionArmMax, "rolling_friction"));
  GENPHYS_RETURN_IF_ERROR(CheckOptional(material.spinning_friction, 0, Limits::kFrictionArmMax, "spinning_friction"));
  return CheckOptional(material.density, Limits::kDensityMin, Limits::kDensityMax, "density");
}

Status CheckShape(const Shape& shape) { return std::visit(ShapeCheck{}, shape); }

Status CheckAutoDisable(const AutoDisable& policy) {
  GENPHYS_RETURN_IF_ERROR(CheckOptional(policy.linear_speed_max, 0, Limits::kSpeedMax, "linear_speed_max"));
  GENPHYS_RETURN_IF_ERROR(CheckOptional(policy.angular_speed_max, 0, Limits::kSpinMax, "angular_speed_max"));
  return CheckOptional(policy.rest_time, 0, Limits::kRestTimeMax, "rest_time_seconds");
}

Status CheckErrorCorrection(const ErrorCorrection& correction) {
  GENPHYS_RETURN_IF_ERROR(
      CheckOptional(correction.time_constant, 0, Limits::kCorrectionTimeMax, "time_constant_seconds"));
  GENPHYS_RETURN_IF_ERROR(CheckOptional(correction.speed_max, 0, Limits::kSpeedMax, "correction_speed_max"));
  return CheckOptional(correction.slop, 0, Limits::kSlopMax, "slop_metres");
}

Status CheckEntity(const EntityDesc& desc) {
  GENPHYS_RETURN_IF_ERROR(CheckPose(desc.pose, "pose"));
  return desc.rigid_body ? WithFieldPrefix(CheckBody(*desc.rigid_body), "rigid_body") : absl::OkStatus();
}

void VisitFeatures(const EntityDesc& desc, FeatureVisit visit) {
  if (!desc.rigid_body) return;
  const RigidBody& body = *desc.rigid_body;
  if (body.error_correction.any()) visit(Feature::kErrorCorrection, std::nullopt, "error_correction");
  if (body.locked_axes.any()) visit(Feature::kLockedAxes, std::nullopt, "locked_axes");
  for (size_t i = 0; i < body.geometries.size(); ++i) {
    const Geometry& geometry = body.geometries[i];
    if (!geometry.surface_velocity.isZero(0)) visit(Feature::kSurfaceVelocity, i, "surface_velocity");
    visit(FeatureOf(geometry.shape), i, "shape");
    if (IsDynamic(desc) && IsSurface(geometry.shape)) {
      const bool is_mesh = std::holds_alternative<TriangleMesh>(geometry.shape);
      visit(is_mesh ? Feature::kDynamicTriangleMesh : Feature::kDynamicHeightfield, i, "shape");
    }
    if (geometry.is_sensor) visit(Feature::kSensors, i, "is_sensor");
  }
}

Status CheckFeatures(const EntityDesc& desc, const Capabilities& capabilities) {
  Status status;
  VisitFeatures(desc, [&](Feature feature, std::optional<size_t> geometry, std::string_view field) {
    if (!status.ok() || capabilities.Has(feature)) return;
    const std::string of = geometry ? Cat("rigid_body.geometries[", *geometry, "].") : "rigid_body.";
    status = UnsupportedFeature(feature, capabilities.engine(), Cat(of, field));
  });
  return status;
}

EntityDesc Filled(const EntityDesc& desc, const WorldDesc& world) {
  EntityDesc filled = desc;
  filled.pose.orientation.normalize();
  if (!filled.rigid_body) return filled;
  RigidBody& body = *filled.rigid_body;
  body.auto_disable = Filled(body.auto_disable, world.default_auto_disable);
  body.error_correction = Filled(body.error_correction, world.default_error_correction);
  NumberGeometries(body.geometries);
  for (Geometry& geometry : body.geometries) {
    geometry.material = Filled(geometry.material, world.default_material);
    geometry.pose_in_entity.orientation.normalize();
    if (Plane* plane = std::get_if<Plane>(&geometry.shape)) plane->normal.normalize();
  }
  return filled;
}

}  // namespace genphys

#pragma once
#include <optional>
#include <string_view>

#include "absl/functional/function_ref.h"
#include "genphys/capabilities.h"
#include "genphys/command.h"
#include "genphys/scene.h"
#include "genphys/status.h"

namespace genphys {

// Each function refuses the first thing that the model does not take, with the path of the field inside its argument.

Status CheckNumber(double value, double min, double max, std::string_view field);
Status CheckVector(const Vector3& value, double bound, std::string_view field);
Status CheckOrientation(const Quaternion& value, std::string_view field);
Status CheckPose(const Pose& pose, std::string_view field);
Status CheckStepper(const StepperDesc& stepper);
Status CheckMaterial(const Material& material);
Status CheckShape(const Shape& shape);
Status CheckAutoDisable(const AutoDisable& policy);
Status CheckErrorCorrection(const ErrorCorrection& correction);

/// Numbers alone; whom it acts on is another matter.
Status CheckForceField(const ForceField& field);

/// Numbers alone: what a world's defaults and the engine's features have to say comes after filling.
Status CheckEntity(const EntityDesc& desc);

using FeatureVisit = absl::FunctionRef<void(Feature, std::optional<size_t> geometry, std::string_view field)>;

/// Calls visit(feature, geometry, field) for each feature that `desc` needs of its engine: `field`, of that geometry or
/// of the body itself, is what needs it.
void VisitFeatures(const EntityDesc& desc, FeatureVisit visit);

/// Features that `desc` needs and `capabilities` lack.
Status CheckFeatures(const EntityDesc& desc, const Capabilities& capabilities);

/// `desc` with every default filled in, directions normalised and geometries numbered.
EntityDesc Filled(const EntityDesc& desc, const WorldDesc& world);

}  // namespace genphys

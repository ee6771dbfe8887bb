#include "missing_features.h"

#include "cat.h"

namespace genphys {

void MissingFeatures::Need(Feature feature) {
  if (!capabilities_.Has(feature)) missing_.set(static_cast<size_t>(feature));
}

void MissingFeatures::Need(const EntityDesc& desc) {
  if (!desc.rigid_body) return;
  const bool is_dynamic = desc.rigid_body->motion_type == MotionType::kDynamic;
  if (desc.rigid_body->error_correction.any()) Need(Feature::kErrorCorrection);
  if (desc.rigid_body->locked_axes.any()) Need(Feature::kLockedAxes);
  for (const Geometry& geometry : desc.rigid_body->geometries) {
    Need(FeatureOf(geometry.shape));
    if (geometry.is_sensor) Need(Feature::kSensors);
    if (!geometry.surface_velocity.isZero(0)) Need(Feature::kSurfaceVelocity);
    if (is_dynamic && std::holds_alternative<TriangleMesh>(geometry.shape)) Need(Feature::kDynamicTriangleMesh);
    if (is_dynamic && std::holds_alternative<Heightfield>(geometry.shape)) Need(Feature::kDynamicHeightfield);
  }
}

void MissingFeatures::Need(const StepperDesc& stepper) {
  is_solver_missing_ = stepper.solver == Solver::kDirect && !capabilities_.Has(Feature::kSolverDirect);
}

Status MissingFeatures::Check() const {
  if (missing_.none() && !is_solver_missing_) return absl::OkStatus();
  std::string names;
  for (size_t i = 0; i < missing_.size(); ++i) {
    const bool is_solver = is_solver_missing_ && static_cast<Feature>(i) == Feature::kSolverDirect;
    if (missing_[i] || is_solver) names += Cat(names.empty() ? "" : ", ", NameOf(static_cast<Feature>(i)));
  }
  return Refuse(Reason::kUnsupportedFeature, missing_.none() ? "stepper.solver" : "engine",
                Cat("engine \"", capabilities_.engine(), "\" does not support ", names));
}

}  // namespace genphys

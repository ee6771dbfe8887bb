#include "missing_features.h"

#include "cat.h"

namespace genphys {

void MissingFeatures::Need(Feature feature) {
  if (!capabilities_.Has(feature)) missing_.set(static_cast<size_t>(feature));
}

void MissingFeatures::Need(const EntityDesc& desc) {
  if (!desc.rigid_body) return;
  const bool is_dynamic = desc.rigid_body->motion_type == MotionType::kDynamic;
  for (const Geometry& geometry : desc.rigid_body->geometries) {
    Need(FeatureOf(geometry.shape));
    if (geometry.is_sensor) Need(Feature::kSensors);
    if (is_dynamic && std::holds_alternative<TriangleMesh>(geometry.shape)) Need(Feature::kDynamicTriangleMesh);
    if (is_dynamic && std::holds_alternative<Heightfield>(geometry.shape)) Need(Feature::kDynamicHeightfield);
  }
}

Status MissingFeatures::Check() const {
  if (missing_.none()) return absl::OkStatus();
  std::string names;
  for (size_t i = 0; i < missing_.size(); ++i) {
    if (missing_[i]) names += Cat(names.empty() ? "" : ", ", NameOf(static_cast<Feature>(i)));
  }
  // Nothing but the stepper's choice: another solver is the way out.
  const bool is_solver = missing_.count() == 1 && missing_[static_cast<size_t>(Feature::kSolverDirect)];
  return Refuse(Reason::kUnsupportedFeature, is_solver ? "stepper.solver" : "engine",
                Cat("engine \"", capabilities_.engine(), "\" does not support ", names));
}

}  // namespace genphys

#include "commands/missing_features.h"

#include "model/cat.h"
#include "model/validate.h"

namespace genphys {

void MissingFeatures::Need(Feature feature) {
  if (!capabilities_.Has(feature)) missing_.set(static_cast<size_t>(feature));
}

void MissingFeatures::Need(const EntityDesc& desc) {
  VisitFeatures(desc, [this](Feature feature, std::optional<size_t>, std::string_view) { Need(feature); });
}

void MissingFeatures::Need(const StepperDesc& stepper) {
  missing_solver_.reset();
  if (stepper.solver == Solver::kAutomatic) return;
  const Feature solver = stepper.solver == Solver::kDirect ? Feature::kSolverDirect : Feature::kSolverIterative;
  if (!capabilities_.Has(solver)) missing_solver_ = solver;
}

Status MissingFeatures::Check() const {
  if (missing_.none() && !missing_solver_) return absl::OkStatus();
  std::string names;
  for (size_t i = 0; i < missing_.size(); ++i) {
    const auto feature = static_cast<Feature>(i);
    if (missing_[i] || missing_solver_ == feature) names += Cat(names.empty() ? "" : ", ", NameOf(feature));
  }
  return Refuse(Reason::kUnsupportedFeature, missing_.none() ? "stepper.solver" : "engine",
                Cat("engine \"", capabilities_.engine(), "\" does not support ", names));
}

}  // namespace genphys

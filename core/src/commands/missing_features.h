#pragma once
#include <bitset>
#include <optional>

#include "genphys/capabilities.h"
#include "genphys/entity.h"
#include "genphys/status.h"
#include "genphys/stepper.h"

namespace genphys {

/// What a world uses and an engine cannot do.
class MissingFeatures {
 public:
  explicit MissingFeatures(const Capabilities& capabilities) : capabilities_(capabilities) {}

  void Need(Feature feature);
  void Need(const EntityDesc& desc);
  void Need(const StepperDesc& stepper);

  /// OK, or UNSUPPORTED_FEATURE with the name of each that is missing. At "engine", or at "stepper.solver" if nothing
  /// but the stepper's choice is: another solver is the way out.
  Status Check() const;

 private:
  const Capabilities& capabilities_;
  std::bitset<static_cast<size_t>(Feature::kCount)> missing_;
  std::optional<Feature> missing_solver_;  // that the stepper asks for
};

}  // namespace genphys

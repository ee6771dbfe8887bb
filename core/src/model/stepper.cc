#include "genphys/stepper.h"

namespace genphys {
namespace {

uint32_t SubstepsOf(Quality quality, const PresetSubsteps& presets) {
  switch (quality) {
    case Quality::kFast:
      return presets.fast;
    case Quality::kBalanced:
      return presets.balanced;
    case Quality::kAccurate:
      return presets.accurate;
  }
  return presets.balanced;
}

}  // namespace

StepperSettings Settle(const StepperDesc& stepper, uint32_t iterations, const PresetSubsteps& presets) {
  return {.solver = stepper.solver,
          .substeps = stepper.substeps.value_or(SubstepsOf(stepper.quality, presets)),
          .iterations = stepper.iterations.value_or(iterations),
          .may_go_on = !stepper.iterations};
}

}  // namespace genphys

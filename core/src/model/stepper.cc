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

// An island of 60 rows takes about as long all at once as in sweeps, and a larger one up to twenty times as long.
// Ragdolls on a floor have 80; a car on four wheels has 46, and takes twice as long in sweeps. All at once, what stands
// and is hit from above stays where it is; in sweeps it mostly gets some cm/s, and up to 3 m/s were seen where 53 kg
// hit it (the engines alone let such rows go at 9 to 15 m/s).
uint32_t JointedRowsOf(Quality quality) {
  constexpr uint32_t kOfFast = 60;
  return quality == Quality::kFast ? kOfFast : StepperSettings{}.jointed_rows_max;
}

}  // namespace

StepperSettings Settle(const StepperDesc& stepper, uint32_t iterations, const PresetSubsteps& presets) {
  return {.solver = stepper.solver,
          .substeps = stepper.substeps.value_or(SubstepsOf(stepper.quality, presets)),
          .iterations = stepper.iterations.value_or(iterations),
          .may_go_on = !stepper.iterations,
          .jointed_rows_max = JointedRowsOf(stepper.quality)};
}

}  // namespace genphys

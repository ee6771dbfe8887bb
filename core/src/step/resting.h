#pragma once
#include <vector>

#include "absl/functional/function_ref.h"
#include "genphys/layer_state.h"
#include "genphys/row_marks.h"
#include "genphys/scene.h"
#include "genphys/state.h"

namespace genphys {

/// What the step knows of bodies besides their velocities.
struct RestMarks {
  const RowMarks& pushed;                     // out of an overlap, or through free space
  const RowMarks& jointed;                    // a joint holds it
  absl::FunctionRef<bool(EntityRow)> swings;  // of these: nothing touches it, nor whom joints hold to it
};

/// Advances LayerState::rest_times of the awake dynamic `rows` by `step_size` seconds, or ends the rest of who moves or
/// may not sleep.
/// At rest is who is no faster than its AutoDisable says, is not pushed, and does not steadily come to go faster.
/// What lies on something trembles by what few sweeps leave over: once at rest it stays so while it is no more than a
/// few times as fast and comes no more than half as far within its rest time as it would at the speeds of its
/// AutoDisable.
void AdvanceRests(const Scene& scene, const StateArrays& state, const std::vector<EntityRow>& rows,
                  const RestMarks& marks, double step_size, LayerState& layer);

/// Whether the entity in `row` may sleep and has rested for as long as its AutoDisable says.
bool HasRested(const Scene& scene, const LayerState& layer, uint32_t row);

}  // namespace genphys

#pragma once
#include <vector>

#include "genphys/layer_state.h"
#include "genphys/row_marks.h"
#include "genphys/scene.h"
#include "genphys/state.h"

namespace genphys {

/// Advances LayerState::rest_times of the awake dynamic `rows` by `step_size` seconds, or ends the rest of who moves or
/// may not sleep.
/// At rest is who is no faster than its AutoDisable says and is not `pushed`, out of an overlap or through free space.
/// What lies on something trembles by what few sweeps leave over: once at rest it stays so while it is no more than a
/// few times as fast and comes no more than half as far within its rest time as it would at the speeds of its
/// AutoDisable.
void AdvanceRests(const Scene& scene, const StateArrays& state, const std::vector<EntityRow>& rows,
                  const RowMarks& pushed, double step_size, LayerState& layer);

/// Whether the entity in `row` may sleep and has rested for as long as its AutoDisable says.
bool HasRested(const Scene& scene, const LayerState& layer, uint32_t row);

}  // namespace genphys

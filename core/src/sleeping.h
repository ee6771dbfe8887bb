#pragma once
#include <vector>

#include "genphys/layer_state.h"
#include "genphys/scene.h"
#include "genphys/state.h"

namespace genphys {

/// Advances the rest times of the awake dynamic `rows` by `step_size` seconds and returns the rows of all islands
/// (dynamic bodies that touch or are joined) in which every body has rested long enough, ascending.
std::vector<EntityRow> RowsToSleep(const Scene& scene, const StateArrays& state, const std::vector<EntityRow>& rows,
                                   const std::vector<uint8_t>& active, double step_size, LayerState& layer);

/// Compares the speeds of `rows` with the thresholds of their AutoDisable, updates LayerState::moving, and tells whose
/// motion started or stopped.
void ReportMoving(const Scene& scene, const StateArrays& state, const std::vector<EntityRow>& rows, LayerState& layer,
                  std::vector<EventKind>& events);

/// `row` and every sleeping dynamic body that it reaches through sleepers that touch or are joined, ascending.
std::vector<EntityRow> SleepingIsland(const Scene& scene, const StateArrays& state, const LayerState& layer,
                                      EntityRow row);

}  // namespace genphys

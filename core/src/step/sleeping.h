#pragma once
#include <span>
#include <vector>

#include "genphys/joint_index.h"
#include "genphys/layer_state.h"
#include "genphys/row_marks.h"
#include "genphys/row_set.h"
#include "genphys/scene.h"
#include "genphys/state.h"

namespace genphys {

/// Those of the awake dynamic `rows` whose islands (dynamic bodies that touch or are joined) are of bodies that have
/// all rested long enough, ascending. `places` is for its own use.
std::vector<EntityRow> RowsToSleep(const Scene& scene, const std::vector<EntityRow>& rows, const JointIndex& joints,
                                   const RowSet& active, const LayerState& layer, RowValues<int>& places);

/// How many groups the awake dynamic `rows` make that touch or are joined; who does neither is a group alone.
uint32_t CountIslands(const Scene& scene, const LayerState& layer, const JointIndex& joints,
                      const std::vector<EntityRow>& rows);

/// Compares the speeds of `rows` with the thresholds of their AutoDisable, updates LayerState::moving, and tells whose
/// motion started or stopped.
void ReportMoving(const Scene& scene, const StateArrays& state, const std::vector<EntityRow>& rows, LayerState& layer,
                  std::vector<EventKind>& events);

/// Every sleeping dynamic body that is among `rows`, or that one of them that sleeps reaches through sleepers that
/// touch or are joined, ascending. `found` is for its own use.
std::vector<EntityRow> SleepingIslands(const Scene& scene, const StateArrays& state, const LayerState& layer,
                                       const JointIndex& joints, std::span<const EntityRow> rows, RowMarks& found);

}  // namespace genphys

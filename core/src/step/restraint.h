#pragma once
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "genphys/backend.h"
#include "genphys/layer_state.h"
#include "genphys/pair_rule.h"
#include "genphys/row_set.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "joints/joint_step.h"
#include "joints/solve_energy.h"
#include "motion/mover.h"

namespace genphys {

/// A solve of joints shall give no energy that nobody put in. The impulses of joints and resting contacts take energy;
/// where light bodies between heavy ones turn far in a step, or where overlaps drive apart what joints hold together,
/// what makes up for errors could give more of it from step to step, until nothing is left of the scene. There errors
/// wait: the island is solved again without making up for them, which gives nothing, and velocities take a part of the
/// difference. So do places of what the layer solved; a larger one once errors are as large as a substep makes them, so
/// that joints do not let go. (Were it always all of it in places, crank B5 of bench/accuracy would be off by four
/// times as much at small steps.) Of what an engine solved places take all, unless that flings them away. Both solves
/// hold up what lies and keep forces within their cones, and so does what lies between.
class Restraint {
 public:
  /// What it needs to know of the world. All of it outlives it.
  struct Surroundings {
    const Scene& scene;
    const LayerState& layer;
    const PairRule& rule;
    const RowSet& active;
    StateArrays& state;
    ContactBuffer& contacts;
    BackendWorld& engine;
    JointStep& joints;
    std::span<const Mover> movers;
    /// Brings bodies (ascending) back to how they were before the solve.
    absl::FunctionRef<void(std::span<const EntityRow>)> return_to_start;
  };

  /// Of a solve of `step_size` seconds.
  Restraint(const Surroundings& world, double step_size) : world_(world), step_size_(step_size) {}

  /// Bodies and contacts are as `rows` were solved, of both the layer and the engine.
  void Apply(std::vector<JointRow>& rows);

 private:
  // A mover of an island of which a part of a solve is taken.
  struct Body {
    const Mover* mover = nullptr;
    uint32_t island = 0;
    Vector3 linear = Vector3::Zero();  // as solved
    Vector3 spin = Vector3::Zero();
    Pose place;                              // to where that took it
    Vector3 quiet_linear = Vector3::Zero();  // as solved without making up for errors
    Vector3 quiet_spin = Vector3::Zero();
  };

  bool IsMovedByOthers(EntityRow row) const;
  const MassProperties& MassOf(EntityRow row) const { return world_.scene.entities[Index(row)]->mass; }
  void FindOpen(std::span<const JointRow> rows);
  void FindEnergies(std::span<const JointRow> rows);
  double WorkBegun(const Mover& mover, const Vector3& gained, double bend_most) const;
  void FindBodies();
  void GoQuietly(std::vector<JointRow>& rows);
  void SolveLeftQuietly(std::vector<JointRow>& rows);
  void SolveAgain(std::span<const EntityRow> left, std::vector<JointRow>& quiet);
  void TakeParts();
  void ShareParts(std::span<const JointRow> solved, const ContactBuffer& solved_contacts,
                  std::vector<JointRow>& rows) const;

  const Surroundings& world_;
  double step_size_;
  std::vector<SolveEnergy> energies_;  // by island
  std::vector<Body> bodies_;
};

}  // namespace genphys

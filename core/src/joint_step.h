#pragma once
#include <span>
#include <vector>

#include "genphys/layer_state.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "joints/row_writer.h"

namespace genphys {

/// The joints of a world over one step: rows for each solve, and what they come to. Arguments outlive this object.
class JointStep {
 public:
  JointStep(const Scene& scene, const StateArrays& state, const std::vector<uint8_t>& active, LayerState& layer)
      : scene_(scene), state_(state), active_(active), layer_(layer) {}

  /// The rows of all joints that hold something awake, at the present poses, for a solve over `h` seconds. Others may
  /// be added behind them.
  std::vector<JointRow>& Write(double h);
  /// Takes what that solve made of them. Velocities must still be those by which it moved the bodies.
  void Take(double h);
  /// Notes where the joints are and what they held over `step_size` seconds; returns those that must break, ascending.
  std::vector<JointId> Finish(double step_size);
  /// Marks the rows that some joint holds.
  void MarkHeld(std::vector<uint8_t>& held) const;
  /// Undoes all of it.
  void Restore();

 private:
  struct Held {
    Vector3 force = Vector3::Zero();   // N*s on b so far
    Vector3 torque = Vector3::Zero();  // N*m*s on b so far
    double share = 1;                  // of the substep, to the time for which its solve acts
  };

  JointSide SideOf(const EntityRef& entity, const Pose& frame, double h) const;
  ErrorCorrection CorrectionOf(const EntityRef& entity) const;
  bool MayHold(const JointDesc& desc) const;
  double Trust(const JointSide& side, uint32_t slot, double h) const;
  // Without `rows` the coordinates alone are noted. False: nothing that it holds can move.
  bool Visit(uint32_t slot, double h, std::vector<JointRow>* rows);

  const Scene& scene_;
  const StateArrays& state_;
  const std::vector<uint8_t>& active_;
  LayerState& layer_;
  std::vector<JointState> saved_;
  bool is_saved_ = false;
  std::vector<JointRow> rows_;
  std::vector<uint32_t> owners_;  // slots of the joints that rows_ are of
  std::vector<double> expected_;  // scratch
  std::vector<Held> held_;        // by slot
  std::vector<uint8_t> was_held_;
};

/// The row of one side of a joint.
inline EntityRow RowOf(const EntityRef& entity) {
  return entity.id.is_null() ? kWorldRow : EntityRow{entity.id.index()};
}

}  // namespace genphys

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "genphys/islands.h"
#include "genphys/joint_row.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "joints/joint_body.h"
#include "joints/row_rate.h"

namespace genphys {

/// Joints that contradict what touches their bodies: of what is led into the floor by a hand that nothing stops. No
/// impulse brings such a joint together. Solvers that try it end anywhere, and faster than anything moves, so that
/// making up for its error waits: see JointState::haste.
class HasteWatch {
 public:
  /// After a solve of `rows` over `h` seconds, whose velocities `state` has. `body_of` tells by entity row who is which
  /// of `bodies`, which are where that began. Arguments outlive this object.
  HasteWatch(const Scene& scene, const StateArrays& state, const Islands& islands, std::span<const JointBody> bodies,
             std::span<const uint32_t> body_of, std::span<const JointRow> rows, double h)
      : scene_(scene), state_(state), islands_(islands), bodies_(bodies), body_of_(body_of), rows_(rows), h_(h) {}

  /// The haste after the solve of a joint, the rows `own`, that had `haste` before. What only is large, so that sweeps
  /// come near slowly, is late, and nothing is in its way: that is pressed harder than anything there weighs.
  double After(std::span<const JointRow> own, uint32_t island, double haste);

  /// Of a joint that nothing is in the way of.
  static double Recovered(double haste);

 private:
  // Squares of what was asked for and of what was not reached, (m/s)^2 or (rad/s)^2.
  struct Shortage {
    double wanted = 0;
    double missed = 0;
    bool IsAny(double creeping) const;
  };

  const JointBody& BodyAt(EntityRow side) const;
  Velocities VelocitiesOf(EntityRow side) const;
  // N*s, with which an island (by its number) presses if nothing is in its way.
  double UsualPress(uint32_t island);

  const Scene& scene_;
  const StateArrays& state_;
  const Islands& islands_;
  std::span<const JointBody> bodies_;
  std::span<const uint32_t> body_of_;
  std::span<const JointRow> rows_;
  double h_;
  std::vector<double> presses_;  // by island; negative: not known yet
};

}  // namespace genphys

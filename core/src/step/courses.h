#pragma once
#include <span>
#include <vector>

#include "genphys/backend.h"
#include "genphys/layer_state.h"
#include "genphys/state.h"

namespace genphys {

/// How kinematic bodies go within one step. Who tells a velocity, or a pose, for each step means a course on which that
/// is the mean of the step. With it from the first substep on, what lies on that would have to get all the change of a
/// step in one of its substeps. So where the last steps tell how it goes on, velocities go straight through the step,
/// to the same pose at its end; what changes otherwise is a jump, and goes evenly. Arguments outlive this object.
class Courses {
 public:
  /// By how much faster something moves at a later time: m/s and rad/s.
  struct Faster {
    Vector3 linear = Vector3::Zero();
    Vector3 angular = Vector3::Zero();
    bool is_zero() const { return linear.isZero(0) && angular.isZero(0); }
  };

  Courses(LayerState& layer, StateArrays& state, double step_size)
      : layer_(layer), state_(state), step_size_(step_size) {}

  /// Those of the active kinematic `rows`, ascending, over the step.
  void Find(std::span<const EntityRow> rows);
  bool empty() const { return courses_.empty(); }
  /// Whether all go on in this step as in the last one.
  bool AreEven() const;
  /// Those that do not, ascending: what is known of how their surfaces slip is not of how they go on from the end.
  std::vector<EntityRow> Uneven() const;

  /// By how much faster it is led in the middle of a substep of `h` seconds than in that of the one before: what jumps
  /// does so before the first one, and counts where `jumps`.
  Faster ChangeOf(EntityRow row, double h, bool jumps) const;

  /// Leads them as in the middle of a substep, so much of the step (0 to 1) after it began.
  void Follow(double part, BackendWorld& engine);
  /// Shows what was told, and remembers it.
  void End(BackendWorld& engine);

  /// Whether what moves by itself goes on otherwise than it was led in the last step.
  bool IsLedOtherwise(EntityRow row) const;

 private:
  struct Course {
    EntityRow row{};
    // As told: m/s and rad/s, the mean of the step.
    Vector3 linear = Vector3::Zero();
    Vector3 angular = Vector3::Zero();
    // By how much faster it is at the end of the step than at its beginning.
    Vector3 gain = Vector3::Zero();
    Vector3 twist = Vector3::Zero();
    // By how much faster than in the last step it goes at once where that is none.
    Vector3 jump = Vector3::Zero();
    Vector3 twist_jump = Vector3::Zero();

    bool IsEven() const;
  };

  bool WasLed(const HalfStep& half) const;

  LayerState& layer_;
  StateArrays& state_;
  double step_size_;             // s
  std::vector<Course> courses_;  // by row
};

}  // namespace genphys

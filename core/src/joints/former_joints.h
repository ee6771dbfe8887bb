#pragma once
#include <span>
#include <vector>

#include "genphys/layer_state.h"
#include "genphys/row_marks.h"
#include "genphys/scene.h"

namespace genphys {

/// What joints were told until commands told them otherwise after the last step: a solve acts from the middle of the
/// last substep on, and to the boundary they went on as they did.
class FormerJoints {
 public:
  /// Takes what the layer has kept.
  void Take(const LayerState& layer, const Scene& scene);
  /// From now on all are as they were.
  void Clear();
  /// Of the coordinates of a joint.
  std::span<const FormerDrive> DrivesOf(JointId id) const;
  /// Or null.
  const FormerFrames* FramesOf(JointId id) const;

  /// Whether one of them is on the entity.
  bool Concern(EntityRow row) const { return !entities_.empty() && entities_[row]; }

 private:
  // Ascending by joint, one of each coordinate and joint.
  std::vector<FormerDrive> drives_;
  std::vector<FormerFrames> frames_;
  RowMarks entities_;
};

/// Leaves of those of each coordinate or joint that is there the first: what it was told in between never was.
void KeepFirst(std::vector<FormerDrive>& drives, const Scene& scene);
void KeepFirst(std::vector<FormerFrames>& frames, const Scene& scene);

/// Whether the axis changes in nothing but springs and drives to positions, so that a solve may act half by the one and
/// half by the other.
bool GoesOn(const JointAxis& before, const JointAxis& after);

/// The same of a joint whose frames change: nothing that it locks is elsewhere.
bool GoesOnElsewhere(const JointDesc& before, const JointDesc& after);

}  // namespace genphys

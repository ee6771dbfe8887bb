#include "joints/former_joints.h"

#include <algorithm>
#include <utility>

#include "genphys/joint_index.h"
#include "genphys/joint_row.h"

namespace genphys {
namespace {

bool IsThere(JointId id, const Scene& scene) {
  const std::optional<SceneJoint>& joint = scene.joints[id.index()];
  return joint && joint->id == id;
}

template <typename Former, typename Key>
void KeepFirstOf(std::vector<Former>& all, const Scene& scene, Key key) {
  std::erase_if(all, [&](const Former& former) { return !IsThere(former.id, scene); });
  std::ranges::stable_sort(all, {}, key);
  const auto again = std::ranges::unique(all, {}, key);
  all.erase(again.begin(), again.end());
}

}  // namespace

void KeepFirst(std::vector<FormerDrive>& drives, const Scene& scene) {
  KeepFirstOf(drives, scene, [](const FormerDrive& drive) { return std::pair(drive.id, drive.place); });
}

void KeepFirst(std::vector<FormerFrames>& frames, const Scene& scene) {
  KeepFirstOf(frames, scene, [](const FormerFrames& each) { return each.id; });
}

void FormerJoints::Take(const LayerState& layer, const Scene& scene) {
  drives_ = layer.former_drives;
  frames_ = layer.former_frames;
  KeepFirst(drives_, scene);
  KeepFirst(frames_, scene);
  entities_.Clear();
  if (drives_.empty() && frames_.empty()) return;
  entities_.Resize(static_cast<uint32_t>(scene.entities.size()));
  const auto mark = [&](JointId id) {
    const JointDesc& joint = scene.joints[id.index()]->desc;
    for (const EntityRow side : {RowOf(joint.entity_a), RowOf(joint.entity_b)}) {
      if (side != kWorldRow) entities_.Mark(side);
    }
  };
  for (const FormerDrive& drive : drives_) mark(drive.id);
  for (const FormerFrames& frames : frames_) mark(frames.id);
}

void FormerJoints::Clear() {
  drives_.clear();
  frames_.clear();
  entities_.Clear();
}

std::span<const FormerDrive> FormerJoints::DrivesOf(JointId id) const {
  if (drives_.empty()) return {};
  const auto mine = std::ranges::equal_range(drives_, id, {}, &FormerDrive::id);
  return {mine.begin(), mine.end()};
}

const FormerFrames* FormerJoints::FramesOf(JointId id) const {
  if (frames_.empty()) return nullptr;
  const auto mine = std::ranges::lower_bound(frames_, id, {}, &FormerFrames::id);
  return mine != frames_.end() && mine->id == id ? &*mine : nullptr;
}

bool GoesOn(const JointAxis& before, const JointAxis& after) {
  if (before.limits != after.limits || before.spring.has_value() != after.spring.has_value()) return false;
  if (before.motor == after.motor) return true;
  return before.motor && after.motor && before.motor->target_position && after.motor->target_position;
}

bool GoesOnElsewhere(const JointDesc& before, const JointDesc& after) {
  JointKind from = before.kind, to = after.kind;
  const auto is_soft = [](const JointAxis* axis) {
    return axis->limits == AxisLimits{} && (!axis->motor || axis->motor->target_position);
  };
  if (!std::ranges::all_of(AxesOf(from), is_soft) || !std::ranges::all_of(AxesOf(to), is_soft)) return false;
  if (!LocksAny(from) && !LocksAny(to)) return true;
  const auto moves = [](const JointKind& kind) {
    const SixDofJoint* const joint = std::get_if<SixDofJoint>(&kind);
    return joint != nullptr && std::ranges::all_of(joint->along, [](const auto& axis) { return axis.has_value(); });
  };
  const auto is_turned = [](const std::optional<Pose>& a, const std::optional<Pose>& b) {
    return !a || !b || a->orientation.normalized().coeffs() != b->orientation.normalized().coeffs();
  };
  return moves(from) && moves(to) && !is_turned(before.frame_in_a, after.frame_in_a) &&
         !is_turned(before.frame_in_b, after.frame_in_b);
}

}  // namespace genphys

#include "world.h"

#include <algorithm>

namespace genphys::ballistic_backend {
namespace {

// The orientation after `time` seconds of constant `spin`: the exponential map, exact and of unit length.
Quaternion Turned(const Quaternion& orientation, const Vector3& spin, double time) {
  const double angle = spin.norm() * time;
  if (angle == 0) return orientation;
  return (Eigen::AngleAxisd(angle, spin.normalized()) * orientation).normalized();
}

}  // namespace

void World::AddBody(const BodyDesc& desc, const StateArrays&) {
  if (Index(desc.row) >= centers_of_mass_.size()) centers_of_mass_.resize(Index(desc.row) + 1);
  centers_of_mass_[Index(desc.row)] = desc.mass.center_of_mass;
}

void World::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer&,
                  std::span<JointRow>) {
  for (EntityRow row : rows) {
    const Vector3& center = centers_of_mass_[Index(row)];
    const Vector3 velocity = state.linear_velocities.col(Index(row));
    const Vector3 spin = state.angular_velocities.col(Index(row));
    const Pose before = state.pose(row);
    const Quaternion orientation = Turned(before.orientation, spin, step_size);
    // The centre of mass goes straight on, and the frame of the entity turns about it.
    const Vector3 swing = before.orientation * center - orientation * center;
    state.set_pose(row, {before.position + swing + step_size * velocity, orientation});
  }
}

}  // namespace genphys::ballistic_backend

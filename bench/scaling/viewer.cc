#include "viewer.h"

namespace genphys::bench {

Viewer::Viewer() {
  request_.set_poses(true);
  request_.set_velocities(true);
  request_.set_deltas(true);
}

void Viewer::Look(const World& world) {
  keyframes_.FollowStep(world);
  v1::WorldStamp stamp;
  stamp.set_step(world.layer_state().step);
  stamp.set_simulation_time_seconds(world.layer_state().simulation_time);
  const Keyframes::Encoded encoded = keyframes_.Encode(world, request_, stamp, known_);
  known_ = encoded.keyframe_id;
  bytes_ = SizeOf(encoded.frame);
}

}  // namespace genphys::bench

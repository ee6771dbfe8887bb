#include "genphys/state.h"

namespace genphys {

void StateArrays::Resize(uint32_t count) {
  const uint32_t before = rows();
  ids.resize(count);
  asleep.resize(count);
  for (Columns3* column : {&positions, &linear_velocities, &angular_velocities, &net_forces, &net_torques}) {
    column->conservativeResize(Eigen::NoChange, count);
  }
  orientations.conservativeResize(Eigen::NoChange, count);
  for (uint32_t i = before; i < count; ++i) {
    for (Columns3* column : {&positions, &linear_velocities, &angular_velocities, &net_forces, &net_torques}) {
      column->col(i).setZero();
    }
    orientations.col(i) = ToColumn(Quaternion::Identity());
  }
}

}  // namespace genphys

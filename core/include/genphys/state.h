#pragma once
#include <cstdint>
#include <vector>

#include "genphys/ids.h"
#include "genphys/math.h"

namespace genphys {

/// What every entity is doing now: parallel columns, row i describes one entity.
/// A removed entity leaves a hole (null id) that a later one fills; rows never move.
struct StateArrays {
  using Columns3 = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  using Columns4 = Eigen::Matrix<double, 4, Eigen::Dynamic>;

  std::vector<EntityId> ids;
  Columns3 positions;           // of the entity's frame, m, world
  Columns4 orientations;        // unit quaternions w x y z, entity to world
  Columns3 linear_velocities;   // of the centre of mass, m/s, world
  Columns3 angular_velocities;  // rad/s, world
  Columns3 net_forces;          // N, world, that acted in the last step: gravity, applied forces and contacts
  Columns3 net_torques;         // N*m about the centre of mass, world
  std::vector<uint8_t> asleep;

  uint32_t rows() const { return static_cast<uint32_t>(ids.size()); }
  Pose pose(EntityRow row) const { return {positions.col(Index(row)), FromColumn(orientations.col(Index(row)))}; }
  void set_pose(EntityRow row, const Pose& pose) {
    positions.col(Index(row)) = pose.position;
    orientations.col(Index(row)) = ToColumn(pose.orientation);
  }
  /// Makes room for `count` rows; new ones are holes.
  void Resize(uint32_t count);
};

}  // namespace genphys

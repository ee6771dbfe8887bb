#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "genphys/ids.h"
#include "genphys/math.h"
#include "genphys/status.h"

namespace genphys::v1 {
class Frame;
class WorldStamp;
}  // namespace genphys::v1

namespace genphys::client {

/// When something was true.
struct Stamp {
  uint64_t step = 0;                   // steps taken
  double simulation_time = 0;          // s
  uint64_t epoch = 0;                  // another one: time went back
  std::optional<uint64_t> state_hash;  // if the world records it
};

Stamp DecodeStamp(const v1::WorldStamp& stamp);

/// The state of a world after one step, as columns: column i of each matrix describes the entity ids()[i].
/// A frame shares the memory that the message came in, and copies of it do too; views live as long as any of them.
class Frame {
 public:
  using Columns3 = Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic>>;
  using Columns4 = Eigen::Map<const Eigen::Matrix<double, 4, Eigen::Dynamic>>;
  using Columns6 = Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic>>;

  /// No entities.
  Frame() = default;
  /// INTERNAL if a column does not fit the number of ids.
  static Result<Frame> Make(std::shared_ptr<const v1::Frame> message);

  const Stamp& stamp() const { return stamp_; }
  uint32_t rows() const { return rows_; }
  /// Ascending.
  std::span<const EntityId> ids() const;
  /// The row of an entity, or nothing if the frame does not have it. Costs a binary search.
  std::optional<uint32_t> row(EntityId id) const;

  // Without columns where they were not asked for.

  /// Of the entity's frame, m, world.
  Columns3 positions() const;
  /// w x y z, entity to world.
  Columns4 orientations() const;
  /// Of the centre of mass, m/s, world.
  Columns3 linear_velocities() const;
  /// rad/s, world.
  Columns3 angular_velocities() const;
  /// xyz force and xyz torque that acted in the last step, N and N*m, world.
  Columns6 net_forces() const;
  bool asleep(uint32_t row) const;

  // Column i describes the joint joint_ids()[i]. Without columns unless joints were asked for.

  /// Ascending.
  std::span<const JointId> joint_ids() const;
  /// The column of a joint, or nothing if the frame does not have it. Costs a binary search.
  std::optional<uint32_t> joint_column(JointId id) const;
  /// Along x y z of the joint frame in metres, about x y z in radians with full turns counted; see JointState.
  Columns6 joint_positions() const;
  /// Of these, m/s and rad/s.
  Columns6 joint_rates() const;
  /// xyz force and xyz torque on b, mean over the last step, N and N*m, world.
  Columns6 joint_forces() const;

  /// The frame must have poses.
  Pose pose(uint32_t row) const;

  /// Frames that this subscriber was too slow for since the one before; zero in the reply to a step.
  uint64_t skipped_frames() const;

 private:
  std::shared_ptr<const v1::Frame> message_;
  Stamp stamp_;
  uint32_t rows_ = 0;
};

}  // namespace genphys::client

#include "motion/locked_axes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "motion/free_rotation.h"

namespace genphys {
namespace {

// Of the mobility of a row: what hangs on it gives way by this part of what it would fall, and that is taken back.
constexpr double kSoftness = 1e-8;

void Drop(const std::array<bool, 3>& locked, Vector3& v) {
  for (int i = 0; i < 3; ++i) {
    if (locked[static_cast<size_t>(i)]) v[i] = 0;
  }
}

bool Any(const std::array<bool, 3>& locked) { return locked[0] || locked[1] || locked[2]; }

}  // namespace

void DropLocked(const LockedAxes& locks, Vector3& linear_velocity, Vector3& angular_velocity) {
  Drop(locks.linear, linear_velocity);
  Drop(locks.angular, angular_velocity);
}

Matrix3 LockedInverse(const LockedAxes& locks, const Matrix3& tensor) {
  // A locked axis apart from the others: they are then inverted by themselves.
  Matrix3 apart = tensor;
  for (int i = 0; i < 3; ++i) {
    if (!locks.angular[static_cast<size_t>(i)]) continue;
    apart.row(i).setZero();
    apart.col(i).setZero();
    apart(i, i) = tensor(i, i);
  }
  Matrix3 inverse = apart.llt().solve(Matrix3::Identity());
  for (int i = 0; i < 3; ++i) {
    if (locks.angular[static_cast<size_t>(i)]) inverse(i, i) = 0;
  }
  return inverse;
}

Vector3 LockedSpin(const LockedAxes& locks, const Matrix3& tensor, const Vector3& spin) {
  if (!Any(locks.angular)) return spin;
  Vector3 left = LockedInverse(locks, tensor) * (tensor * spin);
  Drop(locks.angular, left);
  return left;
}

void WriteLocks(const LockedAxes& locks, const MassProperties& mass, EntityRow row, const Vector3& center,
                const Quaternion& orientation, std::vector<JointRow>& joint_rows) {
  const size_t first = joint_rows.size();
  for (int i = 0; i < 3; ++i) {
    if (!locks.linear[static_cast<size_t>(i)]) continue;
    joint_rows.push_back({.b = row,
                          .kind = JointRow::Kind::kLinear,
                          .axis = Vector3::Unit(i),
                          .point = center,
                          .softness = kSoftness / mass.mass});
  }
  if (joint_rows.size() > first) joint_rows[first].block = static_cast<uint8_t>(joint_rows.size() - first);
  if (!Any(locks.angular)) return;
  const Matrix3 mobility = WorldTensor(orientation, mass.inverse_tensor);
  for (int i = 0; i < 3; ++i) {
    if (!locks.angular[static_cast<size_t>(i)]) continue;
    joint_rows.push_back(
        {.b = row, .kind = JointRow::Kind::kAngular, .axis = Vector3::Unit(i), .softness = kSoftness * mobility(i, i)});
  }
}

const LockedAxes& LockedBodies::locks(EntityRow row) const {
  return scene_.entities[Index(row)]->desc->rigid_body->locked_axes;
}

void LockedBodies::Begin(std::span<const EntityRow> rows) {
  rows_.clear();
  held_.clear();
  for (const EntityRow row : rows) {
    if (!scene_.entities[Index(row)]->traits.is_locked) continue;
    const Pose pose = state_.pose(row);
    rows_.push_back(row);
    held_.push_back({pose.Transform(mass(row).center_of_mass), pose.orientation});
  }
  DropVelocities();
}

std::vector<JointRow>& LockedBodies::Write(const ContactBuffer& contacts, std::vector<JointRow>& joint_rows) {
  if (rows_.empty()) return joint_rows;
  const auto note = [&](EntityRow row) {
    const auto found = std::lower_bound(rows_.begin(), rows_.end(), row);
    if (found != rows_.end() && *found == row) held_[static_cast<size_t>(found - rows_.begin())].may_be_pushed = true;
  };
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    note(pair.entity_a);
    note(pair.entity_b);
  }
  for (const JointRow& row : joint_rows) {
    note(row.a);
    note(row.b);
  }
  for (size_t i = 0; i < rows_.size(); ++i) {
    if (!held_[i].may_be_pushed) continue;
    const EntityRow row = rows_[i];
    WriteLocks(locks(row), mass(row), row, held_[i].center, held_[i].orientation, joint_rows);
  }
  return joint_rows;
}

std::span<const EntityRow> LockedBodies::Finish() {
  for (size_t i = 0; i < rows_.size(); ++i) BringBack(rows_[i], held_[i]);
  return rows_;
}

void LockedBodies::Finish(const RowMarks& among) {
  for (size_t i = 0; i < rows_.size(); ++i) {
    if (among[rows_[i]]) BringBack(rows_[i], held_[i]);
  }
}

void LockedBodies::BringBack(EntityRow row, const Held& held) {
  const LockedAxes& locked = locks(row);
  Pose pose = state_.pose(row);
  Vector3 center = pose.Transform(mass(row).center_of_mass);
  for (int axis = 0; axis < 3; ++axis) {
    if (locked.linear[static_cast<size_t>(axis)]) center[axis] = held.center[axis];
  }
  if (Any(locked.angular)) {
    Vector3 turn = TurnBetween(held.orientation, pose.orientation);
    Drop(locked.angular, turn);
    pose.orientation = Turned(held.orientation, turn, 1);
  }
  pose.position = center - pose.orientation * mass(row).center_of_mass;
  state_.set_pose(row, pose);
  DropVelocity(row);
}

void LockedBodies::Hold(EntityRow row) {
  if (!scene_.entities[Index(row)]->traits.is_locked) return;
  const auto found = std::lower_bound(rows_.begin(), rows_.end(), row);
  if (found != rows_.end() && *found == row) return;
  const Pose pose = state_.pose(row);
  held_.insert(held_.begin() + (found - rows_.begin()), {pose.Transform(mass(row).center_of_mass), pose.orientation});
  rows_.insert(found, row);
}

void LockedBodies::Forget(EntityRow row) {
  const auto found = std::lower_bound(rows_.begin(), rows_.end(), row);
  if (found == rows_.end() || *found != row) return;
  held_.erase(held_.begin() + (found - rows_.begin()));
  rows_.erase(found);
}

void LockedBodies::DropVelocities() {
  for (const EntityRow row : rows_) DropVelocity(row);
}

void LockedBodies::DropVelocity(EntityRow row) {
  const uint32_t column = Index(row);
  Vector3 linear = state_.linear_velocities.col(column), angular = state_.angular_velocities.col(column);
  angular = LockedSpin(locks(row), WorldTensor(state_.pose(row).orientation, mass(row).tensor), angular);
  Drop(locks(row).linear, linear);
  state_.linear_velocities.col(column) = linear;
  state_.angular_velocities.col(column) = angular;
}

}  // namespace genphys

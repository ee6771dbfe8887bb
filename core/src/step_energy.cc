// A solve of joints shall give no energy that nobody put in. The impulses of joints and resting contacts take energy;
// where light bodies between heavy ones turn far in a step, what makes up for errors could give more of it from step to
// step, until nothing is left of the scene. There a solve is taken in part: momentum stays as it is, forces stay within
// their cones, and errors wait.
#include <algorithm>

#include "free_rotation.h"
#include "solve_energy.h"
#include "step_run.h"

namespace genphys {
namespace {

double Square(const Matrix3& tensor, const Vector3& spin) { return spin.dot(tensor * spin); }

}  // namespace

// Of torques from outside, J: a body that joints make harder to turn takes a part of them, and has less energy of it
// than what they do while it turns as joints let it.
double StepRun::WorkOwed(const Mover& mover, const Vector3& turned) {
  if (mover.yield == 1) return 0;
  const Vector3 given = mover.inverse_tensor * mover.momentum;
  const Vector3 before = given - mover.yield * (mover.inverse_tensor * mover.twist);
  const double done = mover.twist.dot(before + given + turned) / 2;
  const double has = mover.yield * mover.twist.dot(before + given) / 2;
  return std::max(done - has, 0.0);
}

bool StepRun::IsMovedByOthers(EntityRow row) const {
  return row != kWorldRow && world_.active_[Index(row)] && !IsDynamic(row);
}

void StepRun::FindEnergies(std::span<const JointRow> rows, std::vector<SolveEnergy>& energies) const {
  const Islands& islands = joints_.islands();
  for (const Mover& mover : movers_) {
    const uint32_t island = islands.IslandOf(mover.row);
    if (island == Islands::kNone || islands.islands()[island].joint_rows == 0) continue;
    const double mass = world_.scene_.entities[Index(mover.row)]->mass.mass;
    const Matrix3& tensor = mover.tensor;
    const Vector3 gained = state_.linear_velocities.col(Index(mover.row)) - mover.linear_given;
    const Vector3 turned = state_.angular_velocities.col(Index(mover.row)) - mover.spin_given;
    SolveEnergy& energy = energies[island];
    energy.first += mass * mover.linear_given.dot(gained) + mover.spin_given.dot(tensor * turned);
    energy.second += (mass * gained.squaredNorm() + Square(tensor, turned)) / 2;
    energy.allowed += WorkOwed(mover, turned);
  }
  joints_.AllowWork(rows, energies);
  const auto open = [&](EntityRow a, EntityRow b) {
    const uint32_t island = islands.IslandOf(a, b);
    if (island != Islands::kNone) energies[island].is_open = true;
  };
  for (const JointRow& row : rows) {
    if (IsMovedByOthers(row.a) || IsMovedByOthers(row.b)) open(row.a, row.b);
  }
  for (const ContactPair& pair : world_.contacts_.pairs) {
    const bool is_run = !pair.surface_velocity.isZero(0);
    if (is_run || IsMovedByOthers(pair.entity_a) || IsMovedByOthers(pair.entity_b)) open(pair.entity_a, pair.entity_b);
  }
}

void StepRun::RestrainJointed(double h, std::vector<JointRow>& rows) {
  if (rows.empty()) return;
  const Islands& islands = joints_.islands();
  std::vector<SolveEnergy> energies(islands.islands().size());
  FindEnergies(rows, energies);
  bool is_any = false;
  for (SolveEnergy& energy : energies) {
    energy.Restrain();
    is_any = is_any || energy.is_restrained;
  }
  if (!is_any) return;
  const auto part_of = [&](EntityRow a, EntityRow b) {
    const uint32_t island = islands.IslandOf(a, b);
    return island != Islands::kNone ? energies[island].part : 1;
  };
  for (JointRow& row : rows) row.impulse *= part_of(row.a, row.b);
  for (const ContactPair& pair : world_.contacts_.pairs) {
    const double part = part_of(pair.entity_a, pair.entity_b);
    for (uint32_t i = pair.first_point; part < 1 && i < pair.first_point + pair.point_count; ++i) {
      world_.contacts_.points[i].normal_impulse *= part;
      world_.contacts_.points[i].friction_impulse *= part;
    }
  }
  std::vector<EntityRow> moved;
  for (const Mover& mover : movers_) {
    const uint32_t island = islands.IslandOf(mover.row);
    if (island == Islands::kNone || !energies[island].is_restrained) continue;
    TakePart(mover, h, energies[island].part);
    moved.push_back(mover.row);
  }
  world_.engine_->WriteState(moved, state_);
}

// Goes from the start of the substep again.
void StepRun::TakePart(const Mover& mover, double h, double part) {
  const auto linear = state_.linear_velocities.col(Index(mover.row));
  const auto angular = state_.angular_velocities.col(Index(mover.row));
  const Vector3 velocity = mover.linear_given + part * (linear - mover.linear_given);
  const Vector3 spin = mover.spin_given + part * (angular - mover.spin_given);
  state_.linear_velocities.col(Index(mover.row)) = velocity;
  state_.angular_velocities.col(Index(mover.row)) = spin;
  const Vector3& center = world_.scene_.entities[Index(mover.row)]->mass.center_of_mass;
  Pose pose{mover.start.Transform(center) + h * velocity, Turned(mover.start.orientation, spin, h)};
  pose.position -= pose.orientation * center;
  state_.set_pose(mover.row, pose);
}

}  // namespace genphys

// A solve of joints shall give no energy that nobody put in. The impulses of joints and resting contacts take energy;
// where light bodies between heavy ones turn far in a step, what makes up for errors could give more of it from step to
// step, until nothing is left of the scene. There errors wait: what the layer solves itself is solved again without
// making up for them, which gives nothing, and a part of the difference is taken; of places a larger one once errors
// are as large as a substep makes them, so that joints do not let go. (Were it always all of it in places, the crank of
// bench/accuracy, B5, would be off by four times as much at small steps.) Of what an engine solved, contacts with it,
// velocities take a part and places all: momentum stays as it is, and forces stay within their cones.
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
  std::vector<SolveEnergy> energies(joints_.islands().islands().size());
  FindEnergies(rows, energies);
  for (SolveEnergy& energy : energies) energy.Restrain();
  if (std::ranges::none_of(energies, &SolveEnergy::is_restrained)) return;
  std::vector<double> impulses(rows.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    impulses[i] = rows[i].impulse;
    rows[i].impulse = 0;
  }
  GoQuietly(rows, energies);
  joints_.BoundWaits(h, rows, energies);
  TakeParts(h, energies);
  const Islands& islands = joints_.islands();
  const auto part_of = [&](EntityRow a, EntityRow b) {
    const uint32_t island = islands.IslandOf(a, b);
    return island != Islands::kNone ? energies[island].part : 1;
  };
  for (size_t i = 0; i < rows.size(); ++i) {
    rows[i].impulse += part_of(rows[i].a, rows[i].b) * (impulses[i] - rows[i].impulse);
  }
  for (const ContactPair& pair : world_.contacts_.pairs) {
    const double part = part_of(pair.entity_a, pair.entity_b);
    for (uint32_t i = pair.first_point; part < 1 && i < pair.first_point + pair.point_count; ++i) {
      world_.contacts_.points[i].normal_impulse *= part;
      world_.contacts_.points[i].friction_impulse *= part;
    }
  }
}

// From what solves without making up for errors give, on to what was solved.
void StepRun::GoQuietly(std::vector<JointRow>& rows, std::vector<SolveEnergy>& energies) {
  for (uint32_t i = 0; i < energies.size(); ++i) {
    SolveEnergy& energy = energies[i];
    if (!energy.is_restrained || !joints_.SolveQuietly(i, rows)) continue;
    energy = {.allowed = energy.allowed, .is_restrained = true, .is_quiet = true, .way = 0};
  }
  for (const Mover& mover : movers_) {
    const uint32_t island = joints_.islands().IslandOf(mover.row);
    const JointBody* const found = joints_.Find(mover.row);
    if (island == Islands::kNone || !energies[island].is_quiet || found == nullptr) continue;
    const JointBody& quiet = *found;
    SolveEnergy& energy = energies[island];
    const double mass = world_.scene_.entities[Index(mover.row)]->mass.mass;
    const Vector3 first = quiet.linear_velocity - mover.linear_given;
    const Vector3 first_turn = quiet.angular_velocity - mover.spin_given;
    const Vector3 rest = state_.linear_velocities.col(Index(mover.row)) - quiet.linear_velocity;
    const Vector3 rest_turn = state_.angular_velocities.col(Index(mover.row)) - quiet.angular_velocity;
    energy.allowed -= mass * first.dot(mover.linear_given + first / 2) +
                      first_turn.dot(mover.tensor * (mover.spin_given + first_turn / 2));
    energy.first += mass * quiet.linear_velocity.dot(rest) + quiet.angular_velocity.dot(mover.tensor * rest_turn);
    energy.second += (mass * rest.squaredNorm() + Square(mover.tensor, rest_turn)) / 2;
  }
  for (SolveEnergy& energy : energies) {
    if (!energy.is_quiet) continue;
    energy.allowed = std::max(energy.allowed, 0.0);
    energy.Restrain();
  }
}

// Goes from the start of the substep again.
void StepRun::TakeParts(double h, std::span<const SolveEnergy> energies) {
  std::vector<EntityRow> moved;
  for (const Mover& mover : movers_) {
    const uint32_t island = joints_.islands().IslandOf(mover.row);
    if (island == Islands::kNone || !energies[island].is_restrained) continue;
    const double part = energies[island].part;
    const JointBody* const quiet = energies[island].is_quiet ? joints_.Find(mover.row) : nullptr;
    const Vector3 linear_from = quiet != nullptr ? quiet->linear_velocity : mover.linear_given;
    const Vector3 spin_from = quiet != nullptr ? quiet->angular_velocity : mover.spin_given;
    auto linear = state_.linear_velocities.col(Index(mover.row));
    auto angular = state_.angular_velocities.col(Index(mover.row));
    const double way = std::max(part, energies[island].way);
    const Vector3 along = linear_from + way * (linear - linear_from);
    const Vector3 turn = spin_from + way * (angular - spin_from);
    linear = linear_from + part * (linear - linear_from);
    angular = spin_from + part * (angular - spin_from);
    const Vector3& center = world_.scene_.entities[Index(mover.row)]->mass.center_of_mass;
    Pose pose{mover.start.Transform(center) + h * along, Turned(mover.start.orientation, turn, h)};
    pose.position -= pose.orientation * center;
    state_.set_pose(mover.row, pose);
    moved.push_back(mover.row);
  }
  world_.engine_->WriteState(moved, state_);
}

}  // namespace genphys

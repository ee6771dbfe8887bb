// A solve of joints shall give no energy that nobody put in. The impulses of joints and resting contacts take energy;
// where light bodies between heavy ones turn far in a step, or where overlaps drive apart what joints hold together,
// what makes up for errors could give more of it from step to step, until nothing is left of the scene. There errors
// wait: the island is solved again without making up for them, which gives nothing, and velocities take a part of the
// difference. So do places of what the layer solved; a larger one once errors are as large as a substep makes them, so
// that joints do not let go. (Were it always all of it in places, crank B5 of bench/accuracy would be off by four times
// as much at small steps.) Of what an engine solved places take all, unless that flings them away. Both solves hold up
// what lies and keep forces within their cones, and so does what lies between.
#include <algorithm>

#include "joints/solve_energy.h"
#include "motion/free_rotation.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// m/s: nothing makes up for errors so fast. An engine that moves something by that did not find its way.
constexpr double kFlung = 50;

double Square(const Matrix3& tensor, const Vector3& spin) { return spin.dot(tensor * spin); }

}  // namespace

// Of torques from outside, J: a body that joints make harder to turn takes a part of them, and has less energy of it
// than what they do while it turns as joints let it.
double StepRun::WorkOwed(const Mover& mover, const Vector3& turned) {
  if (mover.yield == 1) return 0;
  const Vector3 given = mover.turned.inverse * mover.momentum;
  const Vector3 before = given - mover.yield * (mover.turned.inverse * mover.twist);
  const double done = mover.twist.dot(before + given + turned) / 2;
  const double has = mover.yield * mover.twist.dot(before + given) / 2;
  return std::max(done - has, 0.0);
}

// What joints give a body, J, that begins anew or was hit, while it turns about them: half of a substep of what bends
// its way, which is across that only where the half before it was given, too. More than twice what it got is never
// needed.
double StepRun::WorkBegun(const Mover& mover, const Vector3& gained, double h, double bend_most) const {
  const HalfStep& half = world_.layer_.half_steps[Index(mover.row)];
  if (!half.restarts && !half.is_struck) return 0;
  const double mass = world_.scene_.entities[Index(mover.row)]->mass.mass;
  const double bend = std::min(bend_most, h / 2 * mover.spin_given.cross(mover.linear_given).norm());
  return mass * std::min(bend * bend / 2, gained.squaredNorm());
}

bool StepRun::IsMovedByOthers(EntityRow row) const {
  return row != kWorldRow && world_.active_[Index(row)] && !IsDynamic(row);
}

void StepRun::FindEnergies(double h, std::span<const JointRow> rows, std::vector<SolveEnergy>& energies) const {
  const Islands& islands = joints_.islands();
  joints_.AllowWork(h, rows, energies);
  for (const Mover& mover : movers_) {
    const uint32_t island = islands.IslandOf(mover.row);
    if (island == Islands::kNone || islands.islands()[island].joint_rows == 0) continue;
    const double mass = world_.scene_.entities[Index(mover.row)]->mass.mass;
    const Matrix3& tensor = mover.turned.tensor;
    const Vector3 gained = state_.linear_velocities.col(Index(mover.row)) - mover.linear_given;
    const Vector3 turned = state_.angular_velocities.col(Index(mover.row)) - mover.spin_given;
    SolveEnergy& energy = energies[island];
    energy.first += mass * mover.linear_given.dot(gained) + mover.spin_given.dot(tensor * turned);
    energy.second += (mass * gained.squaredNorm() + Square(tensor, turned)) / 2;
    energy.allowed += WorkOwed(mover, turned) + WorkBegun(mover, gained, h, energy.bend);
    // What the bend of its way takes and gives is evened out.
    energy.is_open |= joints_.IsFollowed(mover.row);
  }
  const auto open = [&](EntityRow a, EntityRow b) {
    const uint32_t island = islands.IslandOf(a, b);
    if (island != Islands::kNone) energies[island].is_open = true;
  };
  for (const JointRow& row : rows) {
    if (IsMovedByOthers(row.a) || IsMovedByOthers(row.b)) open(row.a, row.b);
  }
  for (const ContactPair& pair : world_.contacts_.pairs) {
    const bool is_run = world_.rule_.Runs(pair.geometry_a) || world_.rule_.Runs(pair.geometry_b);
    if (is_run || IsMovedByOthers(pair.entity_a) || IsMovedByOthers(pair.entity_b)) open(pair.entity_a, pair.entity_b);
  }
}

void StepRun::RestrainJointed(double h, std::vector<JointRow>& rows) {
  if (rows.empty()) return;
  std::vector<SolveEnergy> energies(joints_.islands().islands().size());
  FindEnergies(h, rows, energies);
  for (SolveEnergy& energy : energies) energy.Restrain();
  if (std::ranges::none_of(energies, &SolveEnergy::is_restrained)) return;
  const std::vector<JointRow> solved = rows;
  const ContactBuffer solved_contacts = world_.contacts_;
  std::vector<Restrained> bodies = RestrainedBodies(energies);
  GoQuietly(h, rows, energies, bodies);
  joints_.BoundWaits(h, rows, energies);
  TakeParts(h, energies, bodies);
  ShareParts(solved, solved_contacts, energies, rows);
}

std::vector<StepRun::Restrained> StepRun::RestrainedBodies(std::span<const SolveEnergy> energies) const {
  std::vector<Restrained> bodies;
  for (const Mover& mover : movers_) {
    const uint32_t island = joints_.islands().IslandOf(mover.row);
    if (island == Islands::kNone || !energies[island].is_restrained) continue;
    const uint32_t row = Index(mover.row);
    bodies.push_back({.mover = &mover,
                      .island = island,
                      .linear = state_.linear_velocities.col(row),
                      .spin = state_.angular_velocities.col(row),
                      .place = state_.pose(mover.row)});
  }
  return bodies;
}

// Solves without making up for errors. What is restrained from then on is the way from there to what was solved.
void StepRun::GoQuietly(double h, std::vector<JointRow>& rows, std::vector<SolveEnergy>& energies,
                        std::vector<Restrained>& bodies) {
  for (uint32_t i = 0; i < energies.size(); ++i) {
    if (!energies[i].is_restrained) continue;
    energies[i] = {.allowed = energies[i].allowed, .is_restrained = true};
    energies[i].is_layers = joints_.SolveQuietly(i, rows);
  }
  SolveLeftQuietly(h, rows, energies, bodies);
  for (Restrained& body : bodies) {
    const Mover& mover = *body.mover;
    SolveEnergy& energy = energies[body.island];
    const JointBody* const found = energy.is_layers ? joints_.Find(mover.row) : nullptr;
    if (found != nullptr) {
      body.quiet_linear = found->linear_velocity;
      body.quiet_spin = found->angular_velocity;
    }
    const double mass = world_.scene_.entities[Index(mover.row)]->mass.mass;
    const Vector3 first = body.quiet_linear - mover.linear_given, first_turn = body.quiet_spin - mover.spin_given;
    const Vector3 rest = body.linear - body.quiet_linear, rest_turn = body.spin - body.quiet_spin;
    energy.allowed -= mass * first.dot(mover.linear_given + first / 2) +
                      first_turn.dot(mover.turned.tensor * (mover.spin_given + first_turn / 2));
    energy.first += mass * body.quiet_linear.dot(rest) + body.quiet_spin.dot(mover.turned.tensor * rest_turn);
    energy.second += (mass * rest.squaredNorm() + Square(mover.turned.tensor, rest_turn)) / 2;
    energy.is_flung |= !energy.is_layers && !(rest.norm() <= kFlung);
  }
  for (SolveEnergy& energy : energies) {
    if (!energy.is_restrained) continue;
    energy.allowed = std::max(energy.allowed, 0.0);
    energy.Restrain();
  }
}

// By the engine, what is not the layer's: from where the substep began.
void StepRun::SolveLeftQuietly(double h, std::vector<JointRow>& rows, std::span<const SolveEnergy> energies,
                               std::vector<Restrained>& bodies) {
  std::vector<EntityRow> left;
  for (const Restrained& body : bodies) {
    if (energies[body.island].is_layers) continue;
    const EntityRow row = body.mover->row;
    state_.set_pose(row, body.mover->start);
    state_.linear_velocities.col(Index(row)) = body.mover->linear_given;
    state_.angular_velocities.col(Index(row)) = body.mover->spin_given;
    left.push_back(row);
  }
  if (left.empty()) return;
  std::ranges::sort(left);
  for (const FrictionTurn& turn : scratch_.turns) {
    for (const EntityRow row : {turn.a, turn.b}) {
      if (std::ranges::binary_search(left, row)) KickTurned(turn, row);
    }
  }
  std::vector<JointRow> quiet;
  std::vector<size_t> places;
  for (size_t i = 0; i < rows.size(); ++i) {
    const uint32_t island = joints_.islands().IslandOf(rows[i].a, rows[i].b);
    if (island == Islands::kNone || !energies[island].is_restrained || energies[island].is_layers) continue;
    quiet.push_back(rows[i]);
    quiet.back().target = JointStep::QuietTarget(rows[i]);
    quiet.back().impulse = 0;
    places.push_back(i);
  }
  // Overlaps are errors too, which some engines make up for by velocities.
  std::vector<double> depths;
  for (ContactPoint& point : world_.contacts_.points) {
    point.normal_impulse = 0;
    point.friction_impulse.setZero();
    depths.push_back(point.depth);
    point.depth = std::min(point.depth, 0.0);
  }
  world_.engine_->WriteState(left, state_);
  world_.engine_->ScaleInertia({});
  world_.engine_->SolveAgain(h, left, state_, world_.contacts_, quiet);
  for (size_t i = 0; i < depths.size(); ++i) world_.contacts_.points[i].depth = depths[i];
  for (size_t i = 0; i < quiet.size(); ++i) rows[places[i]].impulse = quiet[i].impulse;
  for (Restrained& body : bodies) {
    if (energies[body.island].is_layers) continue;
    body.quiet_linear = state_.linear_velocities.col(Index(body.mover->row));
    body.quiet_spin = state_.angular_velocities.col(Index(body.mover->row));
  }
}

void StepRun::TakeParts(double h, std::span<const SolveEnergy> energies, std::span<const Restrained> bodies) {
  std::vector<EntityRow> moved;
  for (const Restrained& body : bodies) {
    const Mover& mover = *body.mover;
    const SolveEnergy& energy = energies[body.island];
    const Vector3 rest = body.linear - body.quiet_linear, rest_turn = body.spin - body.quiet_spin;
    state_.linear_velocities.col(Index(mover.row)) = body.quiet_linear + energy.part * rest;
    state_.angular_velocities.col(Index(mover.row)) = body.quiet_spin + energy.part * rest_turn;
    Pose place = body.place;
    if (energy.is_layers || energy.is_flung) {
      // From the start of the substep again.
      const double way = std::max(energy.part, energy.way);
      const Vector3& center = world_.scene_.entities[Index(mover.row)]->mass.center_of_mass;
      place = {mover.start.Transform(center) + h * (body.quiet_linear + way * rest),
               Turned(mover.start.orientation, body.quiet_spin + way * rest_turn, h)};
      place.position -= place.orientation * center;
    }
    state_.set_pose(mover.row, place);
    moved.push_back(mover.row);
  }
  world_.engine_->WriteState(moved, state_);
}

// The same part of impulses.
void StepRun::ShareParts(std::span<const JointRow> solved, const ContactBuffer& solved_contacts,
                         std::span<const SolveEnergy> energies, std::vector<JointRow>& rows) {
  const auto part_of = [&](EntityRow a, EntityRow b) {
    const uint32_t island = joints_.islands().IslandOf(a, b);
    return island != Islands::kNone ? energies[island].part : 1;
  };
  for (size_t i = 0; i < rows.size(); ++i) {
    const double part = part_of(rows[i].a, rows[i].b);
    rows[i].impulse += part * (solved[i].impulse - rows[i].impulse);
  }
  for (const ContactPair& pair : solved_contacts.pairs) {
    const double part = part_of(pair.entity_a, pair.entity_b);
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      const ContactPoint& from = solved_contacts.points[i];
      ContactPoint& point = world_.contacts_.points[i];
      point.normal_impulse += part * (from.normal_impulse - point.normal_impulse);
      point.friction_impulse += part * (from.friction_impulse - point.friction_impulse);
    }
  }
}

}  // namespace genphys

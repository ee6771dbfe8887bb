#include "step/restraint.h"

#include <algorithm>

#include "motion/free_rotation.h"

namespace genphys {
namespace {

// m/s: nothing makes up for errors so fast. An engine that moves something by that did not find its way.
constexpr double kFlung = 50;

double Square(const Matrix3& tensor, const Vector3& spin) { return spin.dot(tensor * spin); }

// Of torques from outside, J: a body that joints make harder to turn takes a part of them, and has less energy of it
// than what they do while it turns as joints let it.
double WorkOwed(const Mover& mover, const Vector3& turned) {
  if (mover.yield == 1) return 0;
  const Vector3 given = mover.turned.inverse * mover.momentum;
  const Vector3 before = given - mover.yield * (mover.turned.inverse * mover.twist);
  const double done = mover.twist.dot(before + given + turned) / 2;
  const double has = mover.yield * mover.twist.dot(before + given) / 2;
  return std::max(done - has, 0.0);
}

}  // namespace

// What joints give a body, J, that begins anew or was hit, while it turns about them: half of a substep of what bends
// its way, which is across that only where the half before it was given, too. More than twice what it got is never
// needed.
double Restraint::WorkBegun(const Mover& mover, const Vector3& gained, double bend_most) const {
  const HalfStep& half = world_.layer.half_steps[Index(mover.row)];
  if (!half.restarts && !half.is_struck) return 0;
  const double mass = MassOf(mover.row).mass;
  const double bend = std::min(bend_most, step_size_ / 2 * mover.spin_given.cross(mover.linear_given).norm());
  return mass * std::min(bend * bend / 2, gained.squaredNorm());
}

bool Restraint::IsMovedByOthers(EntityRow row) const {
  return row != kWorldRow && world_.active[Index(row)] && !world_.scene.entities[Index(row)]->traits.is_dynamic;
}

// Marks the islands whose energy is nobody's to say.
void Restraint::FindOpen(std::span<const JointRow> rows) {
  const Islands& islands = world_.joints.islands();
  for (const Mover& mover : world_.movers) {
    const uint32_t island = islands.IslandOf(mover.row);
    if (island == Islands::kNone || energies_[island].is_open) continue;
    // What the bend of its way takes and gives is evened out.
    energies_[island].is_open = world_.joints.IsFollowed(mover.row);
  }
  const auto open = [&](EntityRow a, EntityRow b) {
    const uint32_t island = islands.IslandOf(a, b);
    if (island != Islands::kNone) energies_[island].is_open = true;
  };
  EntityRow a = kWorldRow, b = kWorldRow;
  for (const JointRow& row : rows) {
    // Rows of a joint follow each other.
    if (row.a == a && row.b == b) continue;
    a = row.a;
    b = row.b;
    if (IsMovedByOthers(a) || IsMovedByOthers(b)) open(a, b);
  }
  for (const ContactPair& pair : world_.contacts.pairs) {
    const bool is_run = world_.rule.Runs(pair.geometry_a) || world_.rule.Runs(pair.geometry_b);
    if (is_run || IsMovedByOthers(pair.entity_a) || IsMovedByOthers(pair.entity_b)) open(pair.entity_a, pair.entity_b);
  }
}

void Restraint::FindEnergies(std::span<const JointRow> rows) {
  const Islands& islands = world_.joints.islands();
  energies_.assign(islands.islands().size(), {});
  FindOpen(rows);
  if (std::ranges::all_of(energies_, &SolveEnergy::is_open)) return;
  world_.joints.AllowWork(step_size_, rows, energies_);
  for (const Mover& mover : world_.movers) {
    const uint32_t island = islands.IslandOf(mover.row);
    if (island == Islands::kNone || energies_[island].is_open || islands.islands()[island].joint_rows == 0) continue;
    const double mass = MassOf(mover.row).mass;
    const Matrix3& tensor = mover.turned.tensor;
    const Vector3 gained = world_.state.linear_velocities.col(Index(mover.row)) - mover.linear_given;
    const Vector3 turned = world_.state.angular_velocities.col(Index(mover.row)) - mover.spin_given;
    SolveEnergy& energy = energies_[island];
    energy.first += mass * mover.linear_given.dot(gained) + mover.spin_given.dot(tensor * turned);
    energy.second += (mass * gained.squaredNorm() + Square(tensor, turned)) / 2;
    energy.allowed += WorkOwed(mover, turned) + WorkBegun(mover, gained, energy.bend);
  }
}

void Restraint::Apply(std::vector<JointRow>& rows) {
  if (rows.empty()) return;
  FindEnergies(rows);
  for (SolveEnergy& energy : energies_) energy.Restrain();
  if (std::ranges::none_of(energies_, &SolveEnergy::is_restrained)) return;
  const std::vector<JointRow> solved = rows;
  const ContactBuffer solved_contacts = world_.contacts;
  FindBodies();
  GoQuietly(rows);
  world_.joints.BoundWaits(step_size_, rows, energies_);
  TakeParts();
  ShareParts(solved, solved_contacts, rows);
}

void Restraint::FindBodies() {
  bodies_.clear();
  for (const Mover& mover : world_.movers) {
    const uint32_t island = world_.joints.islands().IslandOf(mover.row);
    if (island == Islands::kNone || !energies_[island].is_restrained) continue;
    const uint32_t row = Index(mover.row);
    bodies_.push_back({.mover = &mover,
                       .island = island,
                       .linear = world_.state.linear_velocities.col(row),
                       .spin = world_.state.angular_velocities.col(row),
                       .place = world_.state.pose(mover.row)});
  }
}

// Solves without making up for errors. What is restrained from then on is the way from there to what was solved.
void Restraint::GoQuietly(std::vector<JointRow>& rows) {
  for (uint32_t i = 0; i < energies_.size(); ++i) {
    if (!energies_[i].is_restrained) continue;
    energies_[i] = {.allowed = energies_[i].allowed, .is_restrained = true};
    energies_[i].is_layers = world_.joints.SolveQuietly(i, rows);
  }
  SolveLeftQuietly(rows);
  for (Body& body : bodies_) {
    const Mover& mover = *body.mover;
    SolveEnergy& energy = energies_[body.island];
    const JointBody* const found = energy.is_layers ? world_.joints.Find(mover.row) : nullptr;
    if (found != nullptr) {
      body.quiet_linear = found->linear_velocity;
      body.quiet_spin = found->angular_velocity;
    }
    const double mass = MassOf(mover.row).mass;
    const Vector3 first = body.quiet_linear - mover.linear_given, first_turn = body.quiet_spin - mover.spin_given;
    const Vector3 rest = body.linear - body.quiet_linear, rest_turn = body.spin - body.quiet_spin;
    energy.allowed -= mass * first.dot(mover.linear_given + first / 2) +
                      first_turn.dot(mover.turned.tensor * (mover.spin_given + first_turn / 2));
    energy.first += mass * body.quiet_linear.dot(rest) + body.quiet_spin.dot(mover.turned.tensor * rest_turn);
    energy.second += (mass * rest.squaredNorm() + Square(mover.turned.tensor, rest_turn)) / 2;
    energy.is_flung |= !energy.is_layers && !(rest.norm() <= kFlung);
  }
  for (SolveEnergy& energy : energies_) {
    if (!energy.is_restrained) continue;
    energy.allowed = std::max(energy.allowed, 0.0);
    energy.Restrain();
  }
}

// By the engine, what is not the layer's: from where the substep began.
void Restraint::SolveLeftQuietly(std::vector<JointRow>& rows) {
  std::vector<EntityRow> left;
  for (const Body& body : bodies_) {
    if (!energies_[body.island].is_layers) left.push_back(body.mover->row);
  }
  if (left.empty()) return;
  std::ranges::sort(left);
  world_.return_to_start(left);
  std::vector<JointRow> quiet;
  std::vector<size_t> places;
  for (size_t i = 0; i < rows.size(); ++i) {
    const uint32_t island = world_.joints.islands().IslandOf(rows[i].a, rows[i].b);
    if (island == Islands::kNone || !energies_[island].is_restrained || energies_[island].is_layers) continue;
    quiet.push_back(rows[i]);
    quiet.back().target = JointStep::QuietTarget(rows[i]);
    quiet.back().impulse = 0;
    places.push_back(i);
  }
  SolveAgain(left, quiet);
  for (size_t i = 0; i < quiet.size(); ++i) rows[places[i]].impulse = quiet[i].impulse;
  for (Body& body : bodies_) {
    if (energies_[body.island].is_layers) continue;
    body.quiet_linear = world_.state.linear_velocities.col(Index(body.mover->row));
    body.quiet_spin = world_.state.angular_velocities.col(Index(body.mover->row));
  }
}

void Restraint::SolveAgain(std::span<const EntityRow> left, std::vector<JointRow>& quiet) {
  // Overlaps are errors too, which some engines make up for by velocities.
  std::vector<double> depths;
  for (ContactPoint& point : world_.contacts.points) {
    point.normal_impulse = 0;
    point.friction_impulse.setZero();
    depths.push_back(point.depth);
    point.depth = std::min(point.depth, 0.0);
  }
  world_.engine.ScaleInertia({});
  world_.engine.SolveAgain(step_size_, left, world_.state, world_.contacts, quiet);
  for (size_t i = 0; i < depths.size(); ++i) world_.contacts.points[i].depth = depths[i];
}

void Restraint::TakeParts() {
  std::vector<EntityRow> moved;
  for (const Body& body : bodies_) {
    const Mover& mover = *body.mover;
    const SolveEnergy& energy = energies_[body.island];
    const Vector3 rest = body.linear - body.quiet_linear, rest_turn = body.spin - body.quiet_spin;
    world_.state.linear_velocities.col(Index(mover.row)) = body.quiet_linear + energy.part * rest;
    world_.state.angular_velocities.col(Index(mover.row)) = body.quiet_spin + energy.part * rest_turn;
    Pose place = body.place;
    if (energy.is_layers || energy.is_flung) {
      // From the start of the substep again.
      const double way = std::max(energy.part, energy.way);
      const Vector3& center = MassOf(mover.row).center_of_mass;
      place = {mover.start.Transform(center) + step_size_ * (body.quiet_linear + way * rest),
               Turned(mover.start.orientation, body.quiet_spin + way * rest_turn, step_size_)};
      place.position -= place.orientation * center;
    }
    world_.state.set_pose(mover.row, place);
    moved.push_back(mover.row);
  }
  world_.engine.WriteState(moved, world_.state);
}

// The same part of impulses.
void Restraint::ShareParts(std::span<const JointRow> solved, const ContactBuffer& solved_contacts,
                           std::vector<JointRow>& rows) const {
  const auto part_of = [&](EntityRow a, EntityRow b) {
    const uint32_t island = world_.joints.islands().IslandOf(a, b);
    return island != Islands::kNone ? energies_[island].part : 1;
  };
  for (size_t i = 0; i < rows.size(); ++i) {
    const double part = part_of(rows[i].a, rows[i].b);
    rows[i].impulse += part * (solved[i].impulse - rows[i].impulse);
  }
  for (const ContactPair& pair : solved_contacts.pairs) {
    const double part = part_of(pair.entity_a, pair.entity_b);
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      const ContactPoint& from = solved_contacts.points[i];
      ContactPoint& point = world_.contacts.points[i];
      point.normal_impulse += part * (from.normal_impulse - point.normal_impulse);
      point.friction_impulse += part * (from.friction_impulse - point.friction_impulse);
    }
  }
}

}  // namespace genphys

// Islands that ODE's exact solver solves.
#include <algorithm>
#include <array>
#include <utility>

#include "genphys/most_press.h"
#include "genphys/push_spread.h"
#include "library.h"
#include "world.h"

namespace genphys::ode_backend {
namespace {

// What is uneven gives way less, by as much as it is more uneven, so that what is heavy sinks in no deeper than
// something light would, and stands as straight. Less than the least leaves the exact solver too few of the digits of a
// number.
constexpr double kLeastSoftness = 1e-5;

bool IsFinite(const Motion& motion) {
  return motion.position.allFinite() && motion.orientation.coeffs().allFinite() && motion.linear_velocity.allFinite() &&
         motion.angular_velocity.allFinite();
}

}  // namespace

void World::SolveIsland(uint32_t island, const Call& call) {
  // Of what has joints the layer mostly knows sooner who obeys what than the exact solver finds it out.
  const bool is_direct = IsForDirect(island, call), is_jointed = islands().islands()[island].joint_rows > 0;
  if (is_direct && is_jointed && SolveDirectly(island, call, nullptr, false)) return;
  double softness = 1;
  const bool is_exact = is_direct && IsExact(island, call, softness);
  if (is_exact) most_exact_ = std::max(most_exact_, static_cast<uint32_t>(islands().RowsOf(island).size()));
  if (!is_exact || !SolveExactly(island, softness, call)) Sweep(island, call);
}

// Stacks are what the exact solver is worst at, unless they are small and of very different weights; joints are what it
// is best at.
bool World::IsExact(uint32_t number, const Call& call, double& softness) const {
  if (has_failed_exactly_) return false;
  const bool is_jointed = islands().islands()[number].joint_rows > 0;
  const double spread = SpreadOf(number, call);
  if (!is_jointed && spread >= PushSpread::kUneven) softness = std::max(kLeastSoftness, 1 / spread);
  return ExactSolver::MaySolve(is_jointed, spread);
}

// False if what came out means nothing.
bool World::SolveExactly(uint32_t island, double softness, const Call& call) {
  if (!exact_) exact_.emplace();
  exact_->Begin(static_cast<uint32_t>(islands().RowsOf(island).size()), call.step_size, call.contacts.pull);
  bool is_solved;
  do {
    exact_->Reserve(islands().islands()[island].contacts, islands().JointRowsOf(island).size());
    LoadBodies(island, call.state);
    LoadContacts(island, softness, call);
    LoadRows(island, call);
    is_solved = StepExactly(island);
  } while (exact_ && exact_->IsToBeSolvedAnew(!is_solved));
  is_solved = is_solved && !IsJammed(island, call);
  if (is_solved) {
    exact_->TakeRowImpulses();
    StoreImpulses(call.contacts);
    StoreBodies(island, call.state);
  }
  for (const EntityRow row : islands().RowsOf(island)) body(row).number = kUnsolved;
  return is_solved;
}

bool World::IsJammed(uint32_t island, const Call& call) const {
  const std::span<const uint32_t> rows = islands().JointRowsOf(island);
  if (rows.empty()) return false;
  MostPress most(call.contacts.pull * call.step_size);
  for (const EntityRow row : islands().RowsOf(island)) {
    const Vector3 spin =
        body(row).pose.orientation.conjugate() * Vector3(call.state.angular_velocities.col(Index(row)));
    const double turning = spin.dot(body(row).mass.tensor * spin);
    most.AddWeight(body(row).mass.mass);
    most.AddMotion(body(row).mass.mass, call.state.linear_velocities.col(Index(row)), turning);
  }
  for (const uint32_t row : rows) most.AddDrive(call.joint_rows[row]);
  double pressed = 0;
  for (size_t i = 0; i < solved_.size(); ++i) {
    const ContactPair& pair = call.contacts.pairs[solved_[i].pair];
    pressed += std::max(solved_[i].sign * exact_->Impulse(i).dot(call.PointsOf(pair)[solved_[i].point].normal), 0.0);
  }
  return pressed > most.value();
}

// The solver goes on after an elimination that failed. Where joints contradict each other it ends in the middle, and so
// does all that it worked on.
bool World::StepExactly(uint32_t island) {
  const uint64_t complaints = Complaints();
  try {
    exact_->Step();
  } catch (const EngineFault&) {
    exact_.reset();
    has_failed_exactly_ = true;
    return false;
  }
  for (uint32_t i = 0; i < islands().RowsOf(island).size(); ++i) {
    if (!IsFinite(exact_->motion(i))) return false;
  }
  return Complaints() == complaints;
}

void World::LoadBodies(uint32_t island, const StateArrays& state) {
  uint32_t number = 0;
  for (const EntityRow row : islands().RowsOf(island)) {
    Body& loaded = body(row);
    loaded.number = number++;
    const Motion motion = MotionOf(row, state);
    if (loaded.inertia_factor == 1) {
      exact_->SetBody(loaded.number, loaded.mass, motion);
      continue;
    }
    MassProperties mass = loaded.mass;
    mass.tensor *= loaded.inertia_factor;
    mass.inverse_tensor /= loaded.inertia_factor;
    exact_->SetBody(loaded.number, mass, motion);
  }
}

Motion World::MotionOf(EntityRow row, const StateArrays& state) const {
  return {body(row).CenterOfMass(), body(row).pose.orientation, state.linear_velocities.col(Index(row)),
          state.angular_velocities.col(Index(row))};
}

World::Side World::SideOf(EntityRow row, const StateArrays& state) const {
  if (body(row).motion_type == MotionType::kStatic || !body(row).is_active) return {};
  const Motion motion = MotionOf(row, state);
  return {body(row).number, motion.position, motion.linear_velocity, motion.angular_velocity};
}

// Where each row of a block starts from when the other side moves by itself.
void World::LoadRows(uint32_t island, const Call& call) {
  const auto side_of = [&](EntityRow row) {
    // The world and entities without physics stand still.
    return IsBody(row) ? SideOf(row, call.state) : Side{};
  };
  const std::span<const uint32_t> own = islands().JointRowsOf(island);
  for (size_t first = 0; first < own.size(); first += call.joint_rows[own[first]].block) {
    const std::span<JointRow> block = call.joint_rows.subspan(own[first], call.joint_rows[own[first]].block);
    const Side a = side_of(block[0].a), b = side_of(block[0].b);
    std::array<double, 3> given_rates{};
    for (size_t i = 0; i < block.size(); ++i) {
      const JointRow& row = block[i];
      const bool is_geared = row.kind == JointRow::Kind::kGeared;
      if (a.number == kUnsolved) given_rates[i] += a.RateOf(row, is_geared ? row.axis : -row.axis);
      if (b.number == kUnsolved) given_rates[i] += b.RateOf(row, is_geared ? row.axis_b : row.axis);
    }
    exact_->AddRows(block, a.number, b.number, given_rates);
  }
}

void World::LoadContacts(uint32_t number, double softness, const Call& call) {
  solved_.clear();
  const bool is_jointed = islands().islands()[number].joint_rows > 0;
  const std::span<const uint32_t> pairs = islands().PairsOf(number);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const ContactPair& pair = call.contacts.pairs[pairs[i]];
    const Side a = SideOf(pair.entity_a, call.state), b = SideOf(pair.entity_b, call.state);
    // The solver pushes one side away from the other, and the one that it pushes must be movable.
    const double sign = b.number != kUnsolved ? 1 : -1;
    const Side &pushed = sign > 0 ? b : a, &other = sign > 0 ? a : b;
    ContactConstraint contact{.body = pushed.number,
                              .other = other.number,
                              .is_jointed = is_jointed,
                              .correction = pair.correction,
                              .rolling_friction = pair.material.rolling_friction,
                              .spinning_friction = pair.material.spinning_friction,
                              .relative_spin = pushed.angular_velocity - other.angular_velocity,
                              .rolling = sign * pair.rolling,
                              .load = remembered()[pairs[i]].load,
                              .other_spin = other.number == kUnsolved ? other.angular_velocity : Vector3::Zero(),
                              .softness = softness};
    for (uint32_t j = 0; j < pair.point_count; ++j) {
      const ContactPoint& point = call.contacts.points[pair.first_point + j];
      if (point.is_ahead) continue;
      contact.grip = point.friction * contact.load / pair.point_count;
      LoadContact(pair, point, pushed, other, sign, contact);
      solved_.push_back({pairs[i], j, sign});
    }
  }
}

void World::LoadContact(const ContactPair& pair, const ContactPoint& point, const Side& pushed, const Side& other,
                        double sign, ContactConstraint contact) {
  const Vector3 other_velocity = other.VelocityAt(point.position);
  const bool moves_by_itself = other.number == kUnsolved;
  // How the surface of the pushed side runs against that of the other.
  const auto across = [&](const Vector3& v) { return Vector3(sign * (v - point.normal * point.normal.dot(v))); };
  const Vector3 run = across(pair.surface_velocity + pair.bend);
  contact.position = point.position;
  contact.normal = sign * point.normal;
  contact.depth = point.depth;
  contact.bend = point.bend;
  contact.friction = point.friction;
  contact.relative_velocity = pushed.VelocityAt(point.position) - other_velocity + run;
  contact.slip = across(point.relative_velocity + pair.surface_velocity);
  contact.other_velocity = moves_by_itself ? Vector3(other_velocity - run) : Vector3(-run);
  // Where contacts alone are solved, friction of points that hold each other tells another direction in each solve.
  if (contact.is_jointed) contact.drawn = across(pair.drawn);
  exact_->AddContact(contact);
}

void World::StoreImpulses(ContactBuffer& contacts) {
  for (size_t i = 0; i < solved_.size(); ++i) {
    const Solved& solved = solved_[i];
    ContactPoint& point = contacts.points[contacts.pairs[solved.pair].first_point + solved.point];
    const Vector3 impulse = solved.sign * exact_->Impulse(i);
    point.normal_impulse = impulse.dot(point.normal);
    point.friction_impulse = impulse - point.normal_impulse * point.normal;
    remembered()[solved.pair].impulses[solved.point] = {std::max(point.normal_impulse, 0.0), point.friction_impulse,
                                                        Vector3::Zero()};
  }
}

void World::StoreBodies(uint32_t island, StateArrays& state) {
  for (const EntityRow row : islands().RowsOf(island)) {
    const Motion motion = exact_->motion(body(row).number);
    state.linear_velocities.col(Index(row)) = motion.linear_velocity;
    state.angular_velocities.col(Index(row)) = motion.angular_velocity;
    Pose pose{motion.position, motion.orientation};
    const Vector3& center = body(row).mass.center_of_mass;
    if (!center.isZero(0)) pose.position -= motion.orientation * center;
    Move(row, pose, state);
  }
}

}  // namespace genphys::ode_backend

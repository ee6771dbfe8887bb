// Islands that ODE's exact solver solves.
#include <algorithm>
#include <array>
#include <utility>

#include "library.h"
#include "world.h"

namespace genphys::ode_backend {
namespace {

// An island with joints is solved all at once, unless asked otherwise, while it has no more rows than this.
constexpr size_t kAutomaticRowsMax = 160;
// So is one without joints that has no more rows than this, if weights in it are uneven.
constexpr size_t kUnevenRowsMax = 144;
// What is uneven gives way less, by as much as it is more uneven, so that what is heavy sinks in no deeper than
// something light would, and stands as straight. Less than the least leaves the exact solver too few of the digits of a
// number.
constexpr double kLeastSoftness = 1e-5;
bool IsFinite(const Motion& motion) {
  return motion.position.allFinite() && motion.orientation.coeffs().allFinite() && motion.linear_velocity.allFinite() &&
         motion.angular_velocity.allFinite();
}

}  // namespace

// Stacks are what the exact solver is worst at, unless they are small and of very different weights; joints are what it
// is best at.
bool World::IsExact(uint32_t number, const StateArrays& state, const ContactBuffer& contacts,
                    std::span<const JointRow> joint_rows, double& softness) const {
  const Islands::Island& island = islands_.islands()[number];
  const size_t rows = 3 * island.contacts + island.joint_rows;
  const bool is_asked_for = settings_.solver == Solver::kDirect;
  const bool is_small = rows <= (island.joint_rows > 0 ? kAutomaticRowsMax : kUnevenRowsMax);
  if (settings_.solver == Solver::kIterative || has_failed_exactly_ || !(is_asked_for || is_small)) return false;
  const auto mass_of = [&](EntityRow row) -> PushSpread::Mass {
    const MassProperties& mass = bodies_[Index(row)].mass;
    return {MotionOf(row, state).position, 1 / mass.mass, mass.inverse_tensor.norm()};
  };
  const double spread = PushSpread::Of(islands_, number, contacts, joint_rows, mass_of);
  const bool is_uneven = island.joint_rows == 0 && spread >= PushSpread::kUneven;
  if (is_uneven) softness = std::max(kLeastSoftness, 1 / spread);
  if (!is_asked_for && island.joint_rows == 0 && !is_uneven) return false;
  return ExactSolver::MaySolve(island.contacts, island.joint_rows, spread);
}

// False if what came out means nothing.
bool World::SolveExactly(uint32_t island, double softness, double step_size, StateArrays& state,
                         ContactBuffer& contacts, std::span<JointRow> joint_rows) {
  if (!exact_) exact_.emplace();
  exact_->Begin(static_cast<uint32_t>(islands_.RowsOf(island).size()), step_size, contacts.pull);
  exact_->Reserve(islands_.islands()[island].contacts, islands_.JointRowsOf(island).size());
  LoadBodies(island, state);
  LoadContacts(island, softness, state, contacts);
  LoadRows(island, state, joint_rows);
  const bool is_solved = StepExactly(island);
  if (is_solved) {
    exact_->TakeRowImpulses();
    StoreImpulses(contacts);
    StoreBodies(island, state);
  }
  for (const EntityRow row : islands_.RowsOf(island)) bodies_[Index(row)].solved_as = kUnsolved;
  return is_solved;
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
  for (uint32_t i = 0; i < islands_.RowsOf(island).size(); ++i) {
    if (!IsFinite(exact_->motion(i))) return false;
  }
  return Complaints() == complaints;
}

void World::LoadBodies(uint32_t island, const StateArrays& state) {
  uint32_t number = 0;
  for (const EntityRow row : islands_.RowsOf(island)) {
    Body& body = bodies_[Index(row)];
    body.solved_as = number++;
    const Motion motion = MotionOf(row, state);
    if (body.inertia_factor == 1) {
      exact_->SetBody(body.solved_as, body.mass, motion);
      continue;
    }
    MassProperties mass = body.mass;
    mass.tensor *= body.inertia_factor;
    mass.inverse_tensor /= body.inertia_factor;
    exact_->SetBody(body.solved_as, mass, motion);
  }
}

World::Side World::SideOf(EntityRow row, const StateArrays& state) const {
  const Body& body = bodies_[Index(row)];
  if (body.motion_type == MotionType::kStatic || !body.is_active) return {};
  const Motion motion = MotionOf(row, state);
  return {body.solved_as, motion.position, motion.linear_velocity, motion.angular_velocity};
}

// Where each row of a block starts from when the other side moves by itself.
void World::LoadRows(uint32_t island, const StateArrays& state, std::span<JointRow> joint_rows) {
  const auto side_of = [&](EntityRow row) {
    // The world and entities without physics stand still.
    return IsBody(row) ? SideOf(row, state) : Side{};
  };
  const std::span<const uint32_t> own = islands_.JointRowsOf(island);
  for (size_t first = 0; first < own.size(); first += joint_rows[own[first]].block) {
    const std::span<JointRow> block = joint_rows.subspan(own[first], joint_rows[own[first]].block);
    const Side a = side_of(block[0].a), b = side_of(block[0].b);
    std::array<double, 3> given_rates{};
    for (size_t i = 0; i < block.size(); ++i) {
      const JointRow& row = block[i];
      const bool is_geared = row.kind == JointRow::Kind::kGeared;
      if (a.solved_as == kUnsolved) given_rates[i] += a.RateOf(row, is_geared ? row.axis : -row.axis);
      if (b.solved_as == kUnsolved) given_rates[i] += b.RateOf(row, is_geared ? row.axis_b : row.axis);
    }
    exact_->AddRows(block, a.solved_as, b.solved_as, given_rates);
  }
}

void World::LoadContacts(uint32_t number, double softness, const StateArrays& state, const ContactBuffer& contacts) {
  solved_.clear();
  const bool is_jointed = islands_.islands()[number].joint_rows > 0;
  const std::span<const uint32_t> pairs = islands_.PairsOf(number);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const ContactPair& pair = contacts.pairs[pairs[i]];
    const Side a = SideOf(pair.entity_a, state), b = SideOf(pair.entity_b, state);
    // The solver pushes one side away from the other, and the one that it pushes must be movable.
    const double sign = b.solved_as != kUnsolved ? 1 : -1;
    const Side &pushed = sign > 0 ? b : a, &other = sign > 0 ? a : b;
    ContactConstraint contact{.body = pushed.solved_as,
                              .other = other.solved_as,
                              .is_jointed = is_jointed,
                              .correction = pair.correction,
                              .rolling_friction = pair.material.rolling_friction,
                              .spinning_friction = pair.material.spinning_friction,
                              .relative_spin = pushed.angular_velocity - other.angular_velocity,
                              .other_spin = other.solved_as == kUnsolved ? other.angular_velocity : Vector3::Zero(),
                              .softness = softness};
    for (uint32_t j = 0; j < pair.point_count; ++j) {
      const ContactPoint& point = contacts.points[pair.first_point + j];
      if (point.is_ahead) continue;
      contact.grip = point.friction * memory_.pairs()[pairs[i]].load / pair.point_count;
      LoadContact(pair, point, pushed, other, sign, contact);
      solved_.push_back({pairs[i], j, sign});
    }
  }
}

void World::LoadContact(const ContactPair& pair, const ContactPoint& point, const Side& pushed, const Side& other,
                        double sign, ContactConstraint contact) {
  const Vector3 other_velocity = other.VelocityAt(point.position);
  const bool moves_by_itself = other.solved_as == kUnsolved;
  // How the surface of the pushed side runs against that of the other.
  const auto across = [&](const Vector3& v) { return Vector3(sign * (v - point.normal * point.normal.dot(v))); };
  const Vector3 run = across(pair.surface_velocity + pair.bend);
  contact.position = point.position;
  contact.normal = sign * point.normal;
  contact.depth = point.depth;
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
    memory_.pairs()[solved.pair].impulses[solved.point] = {std::max(point.normal_impulse, 0.0), point.friction_impulse,
                                                           Vector3::Zero()};
  }
}

void World::StoreBodies(uint32_t island, StateArrays& state) {
  for (const EntityRow row : islands_.RowsOf(island)) {
    const Body& body = bodies_[Index(row)];
    const Motion motion = exact_->motion(body.solved_as);
    state.linear_velocities.col(Index(row)) = motion.linear_velocity;
    state.angular_velocities.col(Index(row)) = motion.angular_velocity;
    Pose pose{motion.position, motion.orientation};
    if (!body.is_centered) pose.position -= motion.orientation * body.mass.center_of_mass;
    StorePose(row, pose, state);
  }
}

}  // namespace genphys::ode_backend

#include "world.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "contacts.h"
#include "library.h"

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
// The part of the load of a pair with which a point of it may pull: what sweeps have left over, where none at all would
// end half of the solves of a tower of very different weights.
constexpr double kPullMax = 0.02;
// The part of the speed that contacts of an island had before the solve which may be left, and for few sweeps to do:
// what rests goes on from step to step until nothing is left. (With a thousand times as much few sweeps do for no more
// of the piles of 12 to 45 boxes that were looked at.)
constexpr double kResidualMax = 0.2;
constexpr double kBriefResidualMax = 1e-6;
// Bodies of an island that has not the same solver as larger ones.
constexpr size_t kSmallBodiesMax = 64;

bool IsFinite(const Motion& motion) {
  return motion.position.allFinite() && motion.orientation.coeffs().allFinite() && motion.linear_velocity.allFinite() &&
         motion.angular_velocity.allFinite();
}

// Before a solve too: ODE itself notices in the middle of one, and then its memory for the step is lost.
void CheckFinite(const Motion& motion) {
  if (!motion.linear_velocity.allFinite() || !motion.angular_velocity.allFinite()) {
    throw EngineFault("ODE: a velocity is not finite");
  }
}

}  // namespace

void World::AddBody(const BodyDesc& desc, const StateArrays& state) {
  PrepareThread();
  if (Index(desc.row) >= bodies_.size()) bodies_.resize(Index(desc.row) + 1);
  Body& body = bodies_[Index(desc.row)];
  body.id = desc.id;
  body.serial = ++last_serial_;
  body.motion_type = desc.body.motion_type;
  body.is_active = true;
  if (body.motion_type == MotionType::kDynamic) {
    body.mass = desc.mass;
    body.is_centered = desc.mass.center_of_mass.isZero(0);
  }
  body.geometries.assign(desc.geometries.begin(), desc.geometries.end());

  for (size_t i = 0; i < desc.geometries.size(); ++i) {
    const GeometryRow row = desc.geometries[i];
    if (Index(row) >= shapes_.size()) shapes_.resize(Index(row) + 1);
    shapes_[Index(row)] = PlacedShape(desc.row, desc.body.geometries[i]);
  }
  Move(body, state.pose(desc.row));
}

void World::RemoveBody(EntityRow row) {
  for (GeometryRow geometry : bodies_[Index(row)].geometries) shapes_[Index(geometry)] = PlacedShape();
  std::vector<WarmStart::Kept> forgotten;
  resting_.TakeOf(bodies_[Index(row)].serial, forgotten);
  bodies_[Index(row)] = Body{};
}

void World::SetActive(std::span<const EntityRow> rows, bool active) {
  for (EntityRow row : rows) {
    bodies_[Index(row)].is_active = active;
    if (active) woken_.push_back(bodies_[Index(row)].serial);
  }
  has_slept_ = has_slept_ || !active;
}

void World::WriteState(std::span<const EntityRow> rows, const StateArrays& state) {
  // Solve() takes velocities and centres of mass from the columns, so only the geometries have to follow here.
  for (EntityRow row : rows) Move(bodies_[Index(row)], state.pose(row));
}

void World::Move(Body& body, const Pose& pose) {
  // What is not finite would spoil more than this body, and ODE only notices some of it.
  if (!pose.position.allFinite() || !pose.orientation.coeffs().allFinite()) {
    throw EngineFault("ODE: a pose is not finite");
  }
  body.pose = pose;
  body.is_moved = true;
}

void World::FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) {
  PrepareThread();
  PlaceMoved(a);
  PlaceMoved(b);
  ode_backend::FindPoints(shapes_[Index(a)], shapes_[Index(b)], points);
}

// Only what is near something is ever asked for, so that geometries follow their body when they are.
void World::PlaceMoved(GeometryRow row) {
  Body& body = bodies_[Index(shapes_[Index(row)].entity())];
  if (!body.is_moved) return;
  body.is_moved = false;
  for (GeometryRow own : body.geometries) shapes_[Index(own)].Place(body.pose.position, body.pose.orientation);
}

void World::SetStepper(const StepperSettings& settings) {
  settings_ = settings;
  for (std::optional<ContactSolver>* solver : {&small_solver_, &large_solver_}) {
    if (*solver) (*solver)->SetStepper(settings);
  }
}

void World::ScaleInertia(std::span<const InertiaScale> scales) {
  for (const EntityRow row : scaled_) bodies_[Index(row)].inertia_factor = 1;
  scaled_.clear();
  for (const InertiaScale& scale : scales) {
    bodies_[Index(scale.row)].inertia_factor = scale.factor;
    scaled_.push_back(scale.row);
  }
}

void World::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) {
  SolveIslands(step_size, rows, state, contacts, joint_rows);
  TrimSolvers();
}

// Each island by itself: how many sweeps it gets, in what order ODE takes its rows, and what becomes of it when the
// exact solver gives up must not depend on what is elsewhere.
void World::SolveIslands(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                         std::span<JointRow> joint_rows) {
  PrepareThread();
  islands_.Find(state.rows(), rows, contacts, joint_rows);
  for (EntityRow row : rows) {
    // What nothing holds needs no solver.
    if (islands_.IslandOf(row) == Islands::kNone) Fly(row, step_size, state);
  }
  BringBack();
  warm_start_.Begin();
  if (islands_.islands().empty()) return;
  Recognise(contacts);
  for (uint32_t island = 0; island < islands_.islands().size(); ++island) {
    Attempt attempt = FirstAttempt(island, state, contacts, joint_rows);
    while (const auto next = SolveIsland(attempt, step_size, state, contacts, joint_rows)) attempt.way = *next;
    for (const EntityRow row : islands_.RowsOf(island)) bodies_[Index(row)].solved_as = kUnsolved;
  }
  warm_start_.End(contacts.points);
}

// Bodies that were in use in solves before this one need not be any more.
void World::TrimSolvers() {
  size_t most = 0;
  for (uint32_t island = 0; island < islands_.islands().size(); ++island) {
    most = std::max(most, islands_.RowsOf(island).size());
  }
  if (small_solver_) small_solver_->Trim(static_cast<uint32_t>(std::min(most, kSmallBodiesMax)));
  if (large_solver_) large_solver_->Trim(static_cast<uint32_t>(most > kSmallBodiesMax ? most : 0));
}

std::optional<ContactSolver>& World::SolverOf(uint32_t island) {
  std::optional<ContactSolver>& solver =
      islands_.RowsOf(island).size() > kSmallBodiesMax ? large_solver_ : small_solver_;
  if (!solver) solver.emplace(settings_);
  return solver;
}

void World::SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                       std::span<JointRow> joint_rows) {
  WarmStart remembered = warm_start_;
  warm_start_.TakeBack();
  SolveIslands(step_size, rows, state, contacts, joint_rows);
  warm_start_ = std::move(remembered);
}

World::Attempt World::FirstAttempt(uint32_t number, const StateArrays& state, const ContactBuffer& contacts,
                                   std::span<const JointRow> joint_rows) const {
  const Islands::Island& island = islands_.islands()[number];
  Attempt attempt{.island = number};
  if (settings_.solver != Solver::kIterative && !has_failed_directly_ && IsDirectWanted(island)) {
    const auto mass_of = [&](EntityRow row) -> PushSpread::Mass {
      const MassProperties& mass = bodies_[Index(row)].mass;
      return {MotionOf(row, state).position, 1 / mass.mass, mass.inverse_tensor.norm()};
    };
    const double spread = PushSpread::Of(islands_, number, contacts, joint_rows, mass_of);
    const bool is_uneven = island.joint_rows == 0 && spread >= PushSpread::kUneven;
    if (is_uneven) attempt.softness = std::max(kLeastSoftness, 1 / spread);
    const bool is_easy = settings_.solver == Solver::kAutomatic && island.joint_rows == 0 && !is_uneven;
    if (!is_easy && ContactSolver::MayBeDirect(island.contacts, island.joint_rows, spread)) {
      attempt.way = Way::kDirect;
      return attempt;
    }
  }
  if (!MayBeWarm(number) || !known_[number].is_whole) return attempt;
  attempt.way = settings_.iterations == ContactSolver::kPresetIterations ? Way::kBrief : Way::kWarm;
  return attempt;
}

// Stacks are what the direct solver is worst at, unless they are small and of very different weights; joints are what
// it is best at.
bool World::IsDirectWanted(const Islands::Island& island) const {
  if (settings_.solver == Solver::kDirect) return true;
  const size_t rows = 3 * island.contacts + island.joint_rows;
  return rows <= (island.joint_rows > 0 ? kAutomaticRowsMax : kUnevenRowsMax);
}

// False if what came out means nothing. The exact solver goes on after an elimination that failed. Where joints
// contradict each other it ends in the middle, and so does all that it worked on.
bool World::StepDirectly(uint32_t island) {
  std::optional<ContactSolver>& solver = SolverOf(island);
  const uint64_t complaints = Complaints();
  try {
    solver->Step();
  } catch (const EngineFault&) {
    solver.reset();
    has_failed_directly_ = true;
    return false;
  }
  for (uint32_t i = 0; i < islands_.RowsOf(island).size(); ++i) {
    if (!IsFinite(solver->motion(i))) return false;
  }
  return Complaints() == complaints;
}

// How an island is solved once more that was solved from what held it before, if it must be. One that would have to be
// held by more than contact and friction starts from nothing, and few sweeps are enough to see that. It need not move:
// of four corners one may pull in each guess and carry nothing in truth. So does one of which sweeps left too much, but
// after few of them with more.
std::optional<World::Way> World::WayAfter(const Attempt& attempt, const ContactBuffer& contacts) {
  const bool is_brief = attempt.way == Way::kBrief;
  for (const uint32_t number : islands_.PairsOf(attempt.island)) {
    const ContactPair& pair = contacts.pairs[number];
    double load = 0, grip = 0, pull = 0, held = 0;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      const ContactPoint& point = contacts.points[i];
      load += point.normal_impulse;
      grip += point.friction * point.normal_impulse;
      if (recalled_[i].given.isZero(0)) continue;
      pull = std::max(pull, -point.normal_impulse);
      held += point.friction_impulse.norm();
    }
    if (pull > kPullMax * load || held > grip) return Way::kCold;
  }
  const ContactSolver& solver = *SolverOf(attempt.island);
  // What was given may be very much for something light between heavy ones.
  double speed_before = 0, residual = 0;  // m/s, of its contacts at most
  for (size_t i = 0; i < solved_.size(); ++i) {
    speed_before = std::max(speed_before, solver.SpeedBefore(i));
    residual = std::max(residual, solver.Residual(i));
  }
  // Where some points had nothing to hold, they may have now, and nothing tells what few sweeps left of that.
  const bool is_done = residual <= (is_brief ? kBriefResidualMax : kResidualMax) * speed_before &&
                       (known_[attempt.island].is_all_given || !is_brief);
  if (is_done) return std::nullopt;
  return is_brief ? Way::kWarm : Way::kCold;
}

// How it has to be solved once more, if so.
std::optional<World::Way> World::SolveIsland(const Attempt& attempt, double step_size, StateArrays& state,
                                             ContactBuffer& contacts, std::span<JointRow> joint_rows) {
  const uint32_t island = attempt.island;
  ContactSolver& solver = *SolverOf(island);
  solver.Begin(static_cast<uint32_t>(islands_.RowsOf(island).size()), step_size, contacts.pull);
  LoadBodies(island, state);
  LoadContacts(attempt, state, contacts);
  LoadRows(island, state, joint_rows);
  if (attempt.way == Way::kDirect) {
    if (!StepDirectly(island)) return Way::kCold;
  } else {
    solver.Step(attempt.way == Way::kBrief);
  }
  solver.TakeRowImpulses();
  StoreImpulses(island, contacts);
  if (StartsFromGiven(attempt.way)) {
    if (const std::optional<Way> next = WayAfter(attempt, contacts)) return next;
  }
  StoreBodies(island, state);
  return std::nullopt;
}

void World::Fly(EntityRow row, double step_size, StateArrays& state) {
  const Motion motion = MotionOf(row, state);
  CheckFinite(motion);
  const double angle = motion.angular_velocity.norm() * step_size;
  Quaternion orientation = motion.orientation;
  if (angle > 0) {
    const Eigen::AngleAxisd turn(angle, motion.angular_velocity.normalized());
    orientation = (turn * orientation).normalized();
  }
  StorePose(row, motion.position + step_size * motion.linear_velocity, orientation, state);
}

Motion World::MotionOf(EntityRow row, const StateArrays& state) const {
  const Body& body = bodies_[Index(row)];
  const Pose pose = state.pose(row);
  const uint32_t column = Index(row);
  return {body.is_centered ? pose.position : pose.Transform(body.mass.center_of_mass), pose.orientation,
          state.linear_velocities.col(column), state.angular_velocities.col(column)};
}

void World::LoadBodies(uint32_t island, const StateArrays& state) {
  ContactSolver& solver = *SolverOf(island);
  uint32_t number = 0;
  for (const EntityRow row : islands_.RowsOf(island)) {
    Body& body = bodies_[Index(row)];
    body.solved_as = number++;
    const Motion motion = MotionOf(row, state);
    CheckFinite(motion);
    if (body.inertia_factor == 1) {
      solver.SetBody(body.solved_as, body.mass, motion);
      continue;
    }
    MassProperties mass = body.mass;
    mass.tensor *= body.inertia_factor;
    mass.inverse_tensor /= body.inertia_factor;
    solver.SetBody(body.solved_as, mass, motion);
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
    const bool is_body = Index(row) < bodies_.size() && !bodies_[Index(row)].id.is_null();
    return is_body ? SideOf(row, state) : Side{};
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
    SolverOf(island)->AddRows(block, a.solved_as, b.solved_as, given_rates);
  }
}

void World::LoadContacts(const Attempt& attempt, const StateArrays& state, const ContactBuffer& contacts) {
  solved_.clear();
  const std::span<const uint32_t> pairs = islands_.PairsOf(attempt.island);
  const bool is_given = StartsFromGiven(attempt.way);
  size_t count = 0, held = 0;
  const auto recalled_of = [&](const ContactPair& pair) {
    return std::span(recalled_).subspan(pair.first_point, pair.point_count);
  };
  const auto is_held = [](const WarmStart::Recalled& point) { return !point.given.isZero(0); };
  for (const uint32_t i : pairs) {
    count += contacts.pairs[i].point_count;
    if (is_given) held += static_cast<size_t>(std::ranges::count_if(recalled_of(contacts.pairs[i]), is_held));
  }
  SolverOf(attempt.island)
      ->Reserve(count, held, islands_.JointRowsOf(attempt.island).size(), attempt.way == Way::kDirect);
  for (const uint32_t number : pairs) {
    const ContactPair& pair = contacts.pairs[number];
    const Side a = SideOf(pair.entity_a, state);
    const Side b = SideOf(pair.entity_b, state);
    // What holds two sides together can push them apart by one speed only: that of the point that needs it least.
    double held_depth = std::numeric_limits<double>::infinity();
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      if (is_held(recalled_[i])) held_depth = std::min(held_depth, contacts.points[i].depth);
    }
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      if (!contacts.points[i].is_ahead) LoadContact(attempt, pair, i, a, b, contacts, held_depth);
    }
  }
}

void World::LoadContact(const Attempt& attempt, const ContactPair& pair, uint32_t index, const Side& a, const Side& b,
                        const ContactBuffer& contacts, double held_depth) {
  const ContactPoint& point = contacts.points[index];
  const Islands::Island& island = islands_.islands()[attempt.island];
  // The solver pushes one side away from the other, and the one that it pushes must be movable.
  const double sign = b.solved_as != kUnsolved ? 1 : -1;
  const Side& pushed = sign > 0 ? b : a;
  const Side& other = sign > 0 ? a : b;
  const Vector3 other_velocity = other.VelocityAt(point.position);
  const bool moves_by_itself = other.solved_as == kUnsolved;
  // How the surface of the pushed side runs against that of the other.
  const auto across = [&](const Vector3& v) { return Vector3(sign * (v - point.normal * point.normal.dot(v))); };
  const Vector3 run = across(pair.surface_velocity + pair.bend);
  const WarmStart::Recalled& recalled = recalled_[index];
  // Where contacts alone are swept, friction of points that hold each other tells another direction in each solve.
  const bool is_drawn = island.joint_rows > 0;
  const bool may_share = ContactSolver::MayShareFriction(island.contacts);
  const Vector3 given = StartsFromGiven(attempt.way) ? Vector3(sign * recalled.given) : Vector3::Zero();
  SolverOf(attempt.island)
      ->AddContact({.body = pushed.solved_as,
                    .other = other.solved_as,
                    .position = point.position,
                    .normal = sign * point.normal,
                    .depth = given.isZero(0) ? point.depth : held_depth,
                    .friction = point.friction,
                    .relative_velocity = pushed.VelocityAt(point.position) - other_velocity + run,
                    .slip = across(point.relative_velocity + pair.surface_velocity),
                    .other_velocity = moves_by_itself ? Vector3(other_velocity - run) : Vector3(-run),
                    .braked = sign * recalled.braked,
                    .grip = recalled.grip,
                    .drawn = is_drawn ? across(pair.drawn) : Vector3::Zero(),
                    .is_jointed = island.joint_rows > 0,
                    .correction = pair.correction,
                    .shared_axis = may_share ? recalled.shared_axis : std::nullopt,
                    .rolling_friction = pair.material.rolling_friction,
                    .spinning_friction = pair.material.spinning_friction,
                    .relative_spin = pushed.angular_velocity - other.angular_velocity,
                    .other_spin = moves_by_itself ? other.angular_velocity : Vector3::Zero(),
                    .softness = attempt.softness,
                    .given = given});
  solved_.push_back({index, sign});
}

void World::StoreImpulses(uint32_t island, ContactBuffer& contacts) {
  const ContactSolver& solver = *SolverOf(island);
  for (size_t i = 0; i < solved_.size(); ++i) {
    ContactPoint& point = contacts.points[solved_[i].point];
    const Vector3 impulse = solved_[i].sign * solver.Impulse(i);
    point.normal_impulse = impulse.dot(point.normal);
    point.friction_impulse = impulse - point.normal_impulse * point.normal;
  }
}

void World::StoreBodies(uint32_t island, StateArrays& state) {
  const ContactSolver& solver = *SolverOf(island);
  for (const EntityRow row : islands_.RowsOf(island)) {
    const Motion motion = solver.motion(bodies_[Index(row)].solved_as);
    CheckFinite(motion);
    state.linear_velocities.col(Index(row)) = motion.linear_velocity;
    state.angular_velocities.col(Index(row)) = motion.angular_velocity;
    StorePose(row, motion.position, motion.orientation, state);
  }
}

void World::StorePose(EntityRow row, const Vector3& center_of_mass, const Quaternion& orientation, StateArrays& state) {
  Body& body = bodies_[Index(row)];
  Pose pose{center_of_mass, orientation};
  if (!body.is_centered) pose.position -= orientation * body.mass.center_of_mass;
  state.set_pose(row, pose);
  Move(body, pose);
}

}  // namespace genphys::ode_backend

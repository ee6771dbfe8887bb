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

void World::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) {
  PrepareThread();
  islands_.Find(state.rows(), rows, contacts, joint_rows);
  held_rows_.clear();
  for (EntityRow row : rows) {
    // What nothing holds needs no solver, and ODE would take more time for it than for all the rest.
    if (islands_.IslandOf(row) != Islands::kNone) {
      held_rows_.push_back(row);
    } else {
      Fly(row, step_size, state);
    }
  }
  BringBack();
  warm_start_.Begin();
  solver_->Trim(static_cast<uint32_t>(held_rows_.size()));
  if (held_rows_.empty()) return;
  ChooseSolvers(state, contacts, joint_rows);
  Recognise(contacts);
  for (const Way way : {Way::kDirect, Way::kBrief, Way::kWarm, Way::kCold}) {
    SolveGroup(step_size, way, state, contacts, joint_rows);
  }
  warm_start_.End(contacts.points);
}

void World::SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                       std::span<JointRow> joint_rows) {
  WarmStart remembered = warm_start_;
  warm_start_.TakeBack();
  Solve(step_size, rows, state, contacts, joint_rows);
  warm_start_ = std::move(remembered);
}

void World::NotePush(const Vector3& point, EntityRow row, const StateArrays& state) {
  const uint32_t island = islands_.IslandOf(row);
  if (island == Islands::kNone) return;
  const Body& body = bodies_[Index(row)];
  pushes_[island].spread.Note(point - MotionOf(row, state).position, 1 / body.mass.mass,
                              body.mass.inverse_tensor.norm());
}

void World::ChooseSolvers(const StateArrays& state, const ContactBuffer& contacts,
                          std::span<const JointRow> joint_rows) {
  pushes_.assign(islands_.islands().size(), {});
  if (solver_->solver() == Solver::kIterative || has_failed_directly_) return;
  for (const ContactPair& pair : contacts.pairs) {
    const uint32_t number = islands_.IslandOf(pair.entity_a, pair.entity_b);
    if (pair.is_sensor || number == Islands::kNone || !IsDirectWanted(islands_.islands()[number])) continue;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      for (const EntityRow row : {pair.entity_a, pair.entity_b}) NotePush(contacts.points[i].position, row, state);
    }
  }
  for (const JointRow& row : joint_rows) {
    if (row.kind != JointRow::Kind::kLinear) continue;
    for (const EntityRow side : {row.a, row.b}) NotePush(row.point, side, state);
  }
  for (size_t i = 0; i < pushes_.size(); ++i) {
    const Islands::Island& island = islands_.islands()[i];
    const double spread = pushes_[i].spread.Value();
    pushes_[i].is_uneven = island.joint_rows == 0 && spread >= PushSpread::kUneven;
    if (pushes_[i].is_uneven) pushes_[i].softness = std::max(kLeastSoftness, 1 / spread);
    const bool is_easy = solver_->solver() == Solver::kAutomatic && island.joint_rows == 0 && !pushes_[i].is_uneven;
    const bool is_direct =
        IsDirectWanted(island) && !is_easy && ContactSolver::MayBeDirect(island.contacts, island.joint_rows, spread);
    pushes_[i].way = is_direct ? Way::kDirect : Way::kCold;
  }
}

// Stacks are what the direct solver is worst at, unless they are small and of very different weights; joints are what
// it is best at.
bool World::IsDirectWanted(const Islands::Island& island) const {
  if (solver_->solver() == Solver::kDirect) return true;
  const size_t rows = 3 * island.contacts + island.joint_rows;
  return rows <= (island.joint_rows > 0 ? kAutomaticRowsMax : kUnevenRowsMax);
}

// False if what came out means nothing. The exact solver goes on after an elimination that failed; of which island, it
// does not say. Where joints contradict each other it ends in the middle, and so does all that it worked on.
bool World::StepDirectly() {
  const uint64_t complaints = Complaints();
  try {
    solver_->Step();
  } catch (const EngineFault&) {
    const StepperSettings settings = solver_->settings();
    solver_.emplace(settings);
    has_failed_directly_ = true;
    return false;
  }
  for (uint32_t i = 0; i < solved_rows_.size(); ++i) {
    if (!IsFinite(solver_->motion(i))) return false;
  }
  return Complaints() == complaints;
}

// What was to be solved exactly is not stored, and solved by iterations.
void World::GiveUpDirect() {
  for (Pushes& pushes : pushes_) {
    if (pushes.way == Way::kDirect) pushes.way = Way::kCold;
  }
}

// An island that would have to be held by more than contact and friction is solved again from nothing, and few sweeps
// are enough to see that. It need not move: of four corners one may pull in each guess and carry nothing in truth. So
// is one of which sweeps left too much, but after few of them with more.
void World::GiveUpUnheld(Way way, const ContactBuffer& contacts) {
  const bool is_brief = way == Way::kBrief;
  for (const ContactPair& pair : contacts.pairs) {
    const uint32_t island = islands_.IslandOf(pair.entity_a, pair.entity_b);
    if (pair.is_sensor || island == Islands::kNone || pushes_[island].way != way) continue;
    double load = 0, grip = 0, pull = 0, held = 0;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      const ContactPoint& point = contacts.points[i];
      load += point.normal_impulse;
      grip += point.friction * point.normal_impulse;
      if (recalled_[i].given.isZero(0)) continue;
      pull = std::max(pull, -point.normal_impulse);
      held += point.friction_impulse.norm();
    }
    if (pull > kPullMax * load || held > grip) pushes_[island].way = Way::kCold;
  }
  // What was given may be very much for something light between heavy ones.
  for (size_t i = 0; i < solved_.size(); ++i) {
    double& speed = pushes_[solved_[i].island].speed_before;
    speed = std::max(speed, solver_->SpeedBefore(i));
  }
  for (size_t i = 0; i < solved_.size(); ++i) {
    Pushes& pushes = pushes_[solved_[i].island];
    if (pushes.way != way) continue;
    const double most = (is_brief ? kBriefResidualMax : kResidualMax) * pushes.speed_before;
    // Where some points had nothing to hold, they may have now, and nothing tells what few sweeps left of that.
    const bool is_done = solver_->Residual(i) <= most && (pushes.is_all_given || !is_brief);
    if (!is_done) pushes.way = is_brief ? Way::kWarm : Way::kCold;
  }
}

void World::SolveGroup(double step_size, Way way, StateArrays& state, ContactBuffer& contacts,
                       std::span<JointRow> joint_rows) {
  // Also those of a solve that was given up.
  for (EntityRow row : solved_rows_) bodies_[Index(row)].solved_as = kUnsolved;
  solved_rows_.clear();
  for (EntityRow row : held_rows_) {
    if (pushes_[islands_.IslandOf(row)].way == way) solved_rows_.push_back(row);
  }
  if (solved_rows_.empty()) return;
  solver_->Begin(static_cast<uint32_t>(solved_rows_.size()), step_size);
  LoadBodies(state);
  const bool is_given = StartsFromGiven(way);
  solver_->Reserve(CountContacts(contacts), is_given ? CountGiven() : 0, joint_rows.size(), way == Way::kDirect);
  LoadContacts(way, state, contacts);
  LoadRows(state, joint_rows);
  if (way == Way::kDirect) {
    if (!StepDirectly()) return GiveUpDirect();
  } else {
    solver_->Step(way == Way::kBrief);
  }
  solver_->TakeRowImpulses();
  StoreImpulses(contacts);
  if (is_given) GiveUpUnheld(way, contacts);
  StoreBodies(way, state);
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

void World::LoadBodies(const StateArrays& state) {
  for (uint32_t i = 0; i < solved_rows_.size(); ++i) {
    Body& body = bodies_[Index(solved_rows_[i])];
    body.solved_as = i;
    const Motion motion = MotionOf(solved_rows_[i], state);
    CheckFinite(motion);
    solver_->SetBody(i, body.mass, motion);
  }
  for (const InertiaScale& scale : scales_) {
    const Body& body = bodies_[Index(scale.row)];
    if (body.solved_as == kUnsolved) continue;
    MassProperties mass = body.mass;
    mass.tensor *= scale.factor;
    mass.inverse_tensor /= scale.factor;
    solver_->SetBody(body.solved_as, mass, MotionOf(scale.row, state));
  }
}

World::Side World::SideOf(EntityRow row, const StateArrays& state) const {
  const Body& body = bodies_[Index(row)];
  if (body.motion_type == MotionType::kStatic || !body.is_active) return {};
  const Motion motion = MotionOf(row, state);
  return {body.solved_as, motion.position, motion.linear_velocity, motion.angular_velocity};
}

size_t World::CountContacts(const ContactBuffer& contacts) const {
  size_t count = 0;
  for (const ContactPair& pair : contacts.pairs) count += pair.is_sensor ? 0 : pair.point_count;
  return count;
}

size_t World::CountGiven() const {
  return static_cast<size_t>(
      std::ranges::count_if(recalled_, [](const WarmStart::Recalled& point) { return !point.given.isZero(0); }));
}

// Where each row of a block starts from when the other side moves by itself.
void World::LoadRows(const StateArrays& state, std::span<JointRow> joint_rows) {
  const auto side_of = [&](EntityRow row) {
    // The world and entities without physics stand still.
    const bool is_body = Index(row) < bodies_.size() && !bodies_[Index(row)].id.is_null();
    return is_body ? SideOf(row, state) : Side{};
  };
  for (size_t first = 0; first < joint_rows.size(); first += joint_rows[first].block) {
    const std::span<JointRow> block = joint_rows.subspan(first, joint_rows[first].block);
    const Side a = side_of(block[0].a), b = side_of(block[0].b);
    if (a.solved_as == kUnsolved && b.solved_as == kUnsolved) continue;
    std::array<double, 3> given_rates{};
    for (size_t i = 0; i < block.size(); ++i) {
      const JointRow& row = block[i];
      const bool is_geared = row.kind == JointRow::Kind::kGeared;
      if (a.solved_as == kUnsolved) given_rates[i] += a.RateOf(row, is_geared ? row.axis : -row.axis);
      if (b.solved_as == kUnsolved) given_rates[i] += b.RateOf(row, is_geared ? row.axis_b : row.axis);
    }
    solver_->AddRows(block, a.solved_as, b.solved_as, given_rates);
  }
}

void World::LoadContacts(Way way, const StateArrays& state, const ContactBuffer& contacts) {
  solved_.clear();
  const auto is_solved = [&](const ContactPair& pair) {
    const uint32_t island = islands_.IslandOf(pair.entity_a, pair.entity_b);
    return !pair.is_sensor && island != Islands::kNone && pushes_[island].way == way;
  };
  for (const ContactPair& pair : contacts.pairs) {
    if (!is_solved(pair)) continue;
    const Side a = SideOf(pair.entity_a, state);
    const Side b = SideOf(pair.entity_b, state);
    // What holds two sides together can push them apart by one speed only: that of the point that needs it least.
    double held_depth = std::numeric_limits<double>::infinity();
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      if (!recalled_[i].given.isZero(0)) held_depth = std::min(held_depth, contacts.points[i].depth);
    }
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      if (!contacts.points[i].is_ahead) LoadContact(pair, contacts.points[i], i, a, b, held_depth);
    }
  }
}

void World::LoadContact(const ContactPair& pair, const ContactPoint& point, uint32_t index, const Side& a,
                        const Side& b, double held_depth) {
  // The solver pushes one side away from the other, and the one that it pushes must be movable.
  const double sign = b.solved_as != kUnsolved ? 1 : -1;
  const Side& pushed = sign > 0 ? b : a;
  const Side& other = sign > 0 ? a : b;
  const Vector3 other_velocity = other.VelocityAt(point.position);
  const bool moves_by_itself = other.solved_as == kUnsolved;
  const uint32_t island = islands_.IslandOf(pair.entity_a, pair.entity_b);
  // How the surface of the pushed side runs against that of the other.
  const auto across = [&](const Vector3& v) { return Vector3(sign * (v - point.normal * point.normal.dot(v))); };
  const Vector3 run = across(pair.surface_velocity + pair.bend);
  const WarmStart::Recalled& recalled = recalled_[index];
  const bool may_share = ContactSolver::MayShareFriction(islands_.islands()[island].contacts);
  const bool is_given = StartsFromGiven(pushes_[island].way);
  const Vector3 given = is_given ? Vector3(sign * recalled.given) : Vector3::Zero();
  solver_->AddContact({.body = pushed.solved_as,
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
                       .is_jointed = islands_.islands()[island].joint_rows > 0,
                       .correction = pair.correction,
                       .shared_axis = may_share ? recalled.shared_axis : std::nullopt,
                       .rolling_friction = pair.material.rolling_friction,
                       .spinning_friction = pair.material.spinning_friction,
                       .relative_spin = pushed.angular_velocity - other.angular_velocity,
                       .other_spin = moves_by_itself ? other.angular_velocity : Vector3::Zero(),
                       .softness = pushes_[island].softness,
                       .given = given});
  solved_.push_back({index, island, sign});
}

void World::StoreImpulses(ContactBuffer& contacts) const {
  for (size_t i = 0; i < solved_.size(); ++i) {
    ContactPoint& point = contacts.points[solved_[i].point];
    const Vector3 impulse = solved_[i].sign * solver_->Impulse(i);
    point.normal_impulse = impulse.dot(point.normal);
    point.friction_impulse = impulse - point.normal_impulse * point.normal;
  }
}

void World::StoreBodies(Way way, StateArrays& state) {
  for (uint32_t i = 0; i < solved_rows_.size(); ++i) {
    const EntityRow row = solved_rows_[i];
    if (pushes_[islands_.IslandOf(row)].way != way) continue;
    const Motion motion = solver_->motion(i);
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

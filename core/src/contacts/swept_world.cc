#include "genphys/swept_world.h"

#include <algorithm>
#include <utility>

#include "genphys/push_spread.h"
#include "genphys/work_watch.h"
#include "model/cat.h"

namespace genphys {
namespace {

// Where all islands shall be solved all at once, those that would take too long for it are not: that grows with the
// cube of the rows.
constexpr size_t kDirectContactsMax = 100;
constexpr size_t kDirectRowsMax = 300;
// Rows of an island with joints in which one body weighs PushSpread::kUneven times as much as another, whatever the
// preset: sweeps let what is heavy press out what is light below it, and throw that aside.
constexpr size_t kUnevenRowsMax = 160;
// Of a WorkWatch, for an island, and the rows up to which one may be solved all at once, which takes more than their
// square.
constexpr int64_t kIslandWork = 64;
constexpr size_t kRowsAtOnce = 1000;

}  // namespace

Vector3 SweptWorld::Body::CenterOfMass() const {
  return mass.center_of_mass.isZero(0) ? pose.position : pose.Transform(mass.center_of_mass);
}

Matrix3 SweptWorld::Body::InverseTensor() const {
  const Matrix3 rotation = pose.orientation.toRotationMatrix();
  return rotation * (mass.inverse_tensor / inertia_factor) * rotation.transpose();
}

SweptWorld::SweptWorld(const StepperSettings& settings) { SweptWorld::SetStepper(settings); }

void SweptWorld::AddBody(const BodyDesc& desc, const StateArrays& state) {
  if (Index(desc.row) >= bodies_.size()) bodies_.resize(Index(desc.row) + 1);
  Body& added = body(desc.row);
  added.id = desc.id;
  added.motion_type = desc.body.motion_type;
  added.is_active = true;
  // Who is not dynamic turns about the origin of its frame.
  added.mass = desc.body.motion_type == MotionType::kDynamic ? desc.mass : MassProperties{};
  added.geometries.assign(desc.geometries.begin(), desc.geometries.end());
  for (size_t i = 0; i < desc.geometries.size(); ++i) {
    const GeometryRow row = desc.geometries[i];
    const Geometry& geometry = desc.body.geometries[i];
    if (Index(row) >= geometries_.size()) geometries_.resize(Index(row) + 1);
    geometries_[Index(row)] = {desc.row, geometry.id, geometry.pose_in_entity, geometry.shape, {}};
  }
  SetPose(desc.row, state.pose(desc.row));
}

void SweptWorld::RemoveBody(EntityRow row) {
  for (const GeometryRow geometry : body(row).geometries) geometries_[Index(geometry)] = {};
  memory_.Remove(body(row).id);
  joint_memory_.Remove(body(row).id);
  body(row) = {};
}

void SweptWorld::SetActive(std::span<const EntityRow> rows, bool active) {
  for (const EntityRow row : rows) {
    body(row).is_active = active;
    memory_.SetActive(body(row).id, active);
  }
}

void SweptWorld::PutAway() {
  memory_.PutAway([this](EntityId id) { return MotionOf(id); });
}

// Solve() takes velocities from the columns, so that only poses are kept here.
void SweptWorld::WriteState(std::span<const EntityRow> rows, const StateArrays& state) {
  for (const EntityRow row : rows) SetPose(row, state.pose(row));
}

void SweptWorld::SetStepper(const StepperSettings& settings) {
  settings_ = settings;
  sweeps_.SetIterations(settings.iterations, settings.may_go_on);
}

void SweptWorld::ScaleInertia(std::span<const InertiaScale> scales) {
  for (const EntityRow row : scaled_) body(row).inertia_factor = 1;
  scaled_.clear();
  for (const InertiaScale& scale : scales) {
    body(scale.row).inertia_factor = scale.factor;
    scaled_.push_back(scale.row);
  }
}

void SweptWorld::SetPose(EntityRow row, const Pose& pose) {
  // What is not finite would spoil more than this body.
  if (!pose.position.allFinite() || !pose.orientation.coeffs().allFinite()) {
    throw EngineFault(Cat("the pose of entity ", body(row).id.packed(), " is not finite"));
  }
  body(row).pose = pose;
  body(row).is_moved = true;
}

void SweptWorld::CheckVelocity(EntityRow row, const StateArrays& state) const {
  if (state.linear_velocities.col(Index(row)).allFinite() && state.angular_velocities.col(Index(row)).allFinite()) {
    return;
  }
  throw EngineFault(Cat("the velocity of entity ", body(row).id.packed(), " is not finite"));
}

void SweptWorld::Move(EntityRow row, const Pose& pose, StateArrays& state) {
  CheckVelocity(row, state);
  SetPose(row, pose);
  state.set_pose(row, pose);
}

// Only what is near something is ever asked for, so that geometries follow their body when they are.
const PlacedGeometry& SweptWorld::Placed(GeometryRow row) {
  Body& owner = body(geometries_[Index(row)].entity);
  if (std::exchange(owner.is_moved, false)) {
    const Placement entity = ToPlacement(owner.pose);
    for (const GeometryRow own : owner.geometries) {
      PlacedGeometry& geometry = geometries_[Index(own)];
      geometry.placement = PlacedIn(entity, geometry.pose_in_entity);
      Follow(own, geometry);
    }
  }
  return geometries_[Index(row)];
}

ContactMemory::Motion SweptWorld::MotionOf(EntityId id) const {
  using Motion = ContactMemory::Motion;
  const EntityRow row{id.index()};
  if (!IsBody(row) || body(row).id != id) return Motion::kGone;
  if (body(row).motion_type == MotionType::kStatic) return Motion::kNone;
  return body(row).is_active ? Motion::kMoving : Motion::kResting;
}

// In the frame of what slides over the other its points stand still.
std::pair<ContactMemory::Key, Placement> SweptWorld::Identify(const ContactPair& pair) {
  const Body &a = body(pair.entity_a), &b = body(pair.entity_b);
  const GeometryRow frame = b.motion_type == MotionType::kDynamic ? pair.geometry_b : pair.geometry_a;
  return {{a.id, b.id, geometries_[Index(pair.geometry_a)].id, geometries_[Index(pair.geometry_b)].id},
          Placed(frame).placement};
}

void SweptWorld::Recall(const ContactBuffer& solved) {
  memory_.Recall(
      solved, [&](const ContactPair& pair) { return Identify(pair); },
      [&](const ContactPair& pair, std::vector<ContactPoint>& points) {
        FindPoints(pair.geometry_a, pair.geometry_b, points);
      });
}

// Each island by itself: nothing that is decided for one must depend on what is elsewhere.
void SweptWorld::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                       std::span<JointRow> joint_rows) {
  for (const EntityRow row : rows) CheckVelocity(row, state);
  memory_.Recognise(
      contacts, [&](EntityId id) { return MotionOf(id); }, [&](const ContactPair& pair) { return Identify(pair); });
  islands_.Find(state.rows(), rows, contacts, joint_rows);
  const auto id_of = [this](EntityRow row) { return IdOf(row); };
  joint_memory_.Recall(joint_rows, id_of);
  for (const EntityRow row : rows) {
    if (islands_.IslandOf(row) != Islands::kNone) continue;
    // What nothing holds needs no solver.
    const SweptBody free{.linear_velocity = state.linear_velocities.col(Index(row)),
                         .angular_velocity = state.angular_velocities.col(Index(row))};
    Move(row, MovedBy(free, step_size, body(row).mass.center_of_mass, body(row).pose), state);
  }
  for (ContactPoint& point : contacts.points) {
    point.normal_impulse = 0;
    point.friction_impulse.setZero();
  }
  const Call call{step_size, state, contacts, joint_rows};
  for (uint32_t number = 0; number < islands_.islands().size(); ++number) {
    const Islands::Island& island = islands_.islands()[number];
    const auto size = static_cast<int64_t>(std::min<size_t>(3 * island.contacts + island.joint_rows, kRowsAtOnce));
    WorkWatch::Spend(kIslandWork + size * size);
    SolveIsland(number, call);
  }
  joint_memory_.Note(joint_rows, id_of);
}

void SweptWorld::SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state,
                            ContactBuffer& contacts, std::span<JointRow> joint_rows) {
  ContactMemory kept = std::exchange(memory_, memory_.OfBefore());
  JointMemory joints_kept = joint_memory_;
  SweptWorld::Solve(step_size, rows, state, contacts, joint_rows);
  memory_ = std::move(kept);
  joint_memory_ = std::move(joints_kept);
}

void SweptWorld::SaveState(std::string& bytes) const {
  memory_.Save(bytes);
  joint_memory_.Save(bytes);
}

double SweptWorld::SpreadOf(uint32_t island, const Call& call) const {
  const auto mass_of = [&](EntityRow row) -> PushSpread::Mass {
    const Body& pushed = body(row);
    return {pushed.CenterOfMass(), 1 / pushed.mass.mass, pushed.mass.inverse_tensor.norm()};
  };
  return PushSpread::Of(islands_, island, call.contacts, call.joint_rows, mass_of);
}

bool SweptWorld::IsForDirect(uint32_t number, const Call& call) const {
  const Islands::Island& island = islands_.islands()[number];
  const auto is_stuck = [&](uint32_t row) { return call.joint_rows[row].is_stuck; };
  if (std::ranges::any_of(islands_.JointRowsOf(number), is_stuck)) return false;
  switch (settings_.solver) {
    case Solver::kIterative:
      return false;
    case Solver::kDirect:
      return island.contacts <= kDirectContactsMax && island.joint_rows <= kDirectRowsMax;
    case Solver::kAutomatic:
      break;
  }
  if (island.joint_rows > 0) {
    const size_t rows = 3 * island.contacts + island.joint_rows;
    if (rows <= settings_.jointed_rows_max) return true;
    const auto weight = [&](EntityRow row) { return body(row).mass.mass; };
    const auto [lightest, heaviest] = std::ranges::minmax(islands_.RowsOf(number), {}, weight);
    return rows <= kUnevenRowsMax && weight(heaviest) >= PushSpread::kUneven * weight(lightest);
  }
  return island.contacts <= kUnevenPointsMax && SpreadOf(number, call) >= PushSpread::kUneven;
}

void SweptWorld::Sweep(uint32_t number, const Call& call) {
  LoadSweeps(number, call);
  sweeps_.Solve();
  TakeSweeps(number, call, true);
}

bool SweptWorld::SolveDirectly(uint32_t number, const Call& call, BoundedSolver* bounded, bool may_sweep) {
  LoadSweeps(number, call);
  const bool is_solved = sweeps_.SolveDirectly(bounded, may_sweep);
  TakeSweeps(number, call, is_solved);
  return is_solved;
}

void SweptWorld::LoadSweeps(uint32_t number, const Call& call) {
  const Islands::Island& island = islands_.islands()[number];
  const bool are_few = island.contacts <= ContactSweeps::kFewPoints && island.joint_rows == 0;
  sweeps_.Begin(call.step_size, call.contacts.pull, are_few);
  for (const EntityRow row : islands_.RowsOf(number)) body(row).number = sweeps_.AddBody(Swept(row, call.state));
  for (const uint32_t i : islands_.PairsOf(number)) {
    const ContactPair& pair = call.contacts.pairs[i];
    ContactMemory::PerPoint<PointImpulse>& impulses = memory_.pairs()[i].impulses;
    sweeps_.AddPair(NumberOf(pair.entity_a, call.state), NumberOf(pair.entity_b, call.state), pair, call.PointsOf(pair),
                    {impulses.data(), impulses.size()});
  }
  for (const uint32_t i : islands_.JointRowsOf(number)) {
    JointRow& row = call.joint_rows[i];
    sweeps_.AddRow(NumberOf(row.a, call.state), NumberOf(row.b, call.state), row);
  }
}

void SweptWorld::TakeSweeps(uint32_t number, const Call& call, bool is_solved) {
  for (const EntityRow row : islands_.RowsOf(number)) {
    const uint32_t own = std::exchange(body(row).number, kUnsolved);
    if (is_solved) TakeSwept(row, sweeps_.body(own), call);
  }
  for (const EntityRow row : driven_) body(row).number = kUnsolved;
  driven_.clear();
}

SweptBody SweptWorld::Swept(EntityRow row, const StateArrays& state) const {
  const Body& from = body(row);
  SweptBody swept{.is_dynamic = from.motion_type == MotionType::kDynamic,
                  .center = from.CenterOfMass(),
                  .linear_velocity = state.linear_velocities.col(Index(row)),
                  .angular_velocity = state.angular_velocities.col(Index(row))};
  if (!swept.is_dynamic) return swept;
  swept.inverse_mass = 1 / from.mass.mass;
  swept.inverse_tensor = from.InverseTensor();
  return swept;
}

// The world, entities without physics, and what does not move are one.
uint32_t SweptWorld::NumberOf(EntityRow row, const StateArrays& state) {
  if (!IsBody(row)) return ContactSweeps::kFixed;
  Body& side = body(row);
  if (side.number == kUnsolved && side.motion_type == MotionType::kKinematic && side.is_active) {
    side.number = sweeps_.AddBody(Swept(row, state));
    driven_.push_back(row);
  }
  return side.number == kUnsolved ? ContactSweeps::kFixed : side.number;
}

void SweptWorld::TakeSwept(EntityRow row, const SweptBody& swept, const Call& call) {
  call.state.linear_velocities.col(Index(row)) = swept.linear_velocity;
  call.state.angular_velocities.col(Index(row)) = swept.angular_velocity;
  Move(row, MovedBy(swept, call.step_size, body(row).mass.center_of_mass, body(row).pose), call.state);
}

}  // namespace genphys

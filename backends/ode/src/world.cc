#include "world.h"

#include <algorithm>
#include <utility>

#include "contacts.h"
#include "library.h"

namespace genphys::ode_backend {
namespace {

// Those of `contacts`, which are const or not.
auto PointsOf(const ContactPair& pair, auto& contacts) {
  return std::span(contacts.points).subspan(pair.first_point, pair.point_count);
}

}  // namespace

void World::AddBody(const BodyDesc& desc, const StateArrays& state) {
  PrepareThread();
  if (Index(desc.row) >= bodies_.size()) bodies_.resize(Index(desc.row) + 1);
  Body& body = bodies_[Index(desc.row)];
  body.id = desc.id;
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
  memory_.Remove(bodies_[Index(row)].id);
  bodies_[Index(row)] = Body{};
}

void World::SetActive(std::span<const EntityRow> rows, bool active) {
  for (EntityRow row : rows) {
    bodies_[Index(row)].is_active = active;
    memory_.SetActive(bodies_[Index(row)].id, active);
  }
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
  sweeps_.SetIterations(settings.iterations);
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
  most_exact_ = 0;
  SolveIslands(step_size, rows, state, contacts, joint_rows);
  // Bodies that were in use in solves before this one need not be any more.
  if (exact_) exact_->Trim(most_exact_);
}

// Each island by itself: how many sweeps it gets, and what becomes of it when the exact solver gives up must not depend
// on what is elsewhere.
void World::SolveIslands(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                         std::span<JointRow> joint_rows) {
  PrepareThread();
  for (const EntityRow row : rows) CheckFinite(row, state);
  memory_.Recognise(
      contacts, [&](EntityId id) { return MemoryMotionOf(id); },
      [&](const ContactPair& pair) { return Identify(pair); });
  islands_.Find(state.rows(), rows, contacts, joint_rows);
  for (const EntityRow row : rows) {
    if (islands_.IslandOf(row) != Islands::kNone) continue;
    // What nothing holds needs no solver.
    const SweptBody free{.linear_velocity = state.linear_velocities.col(Index(row)),
                         .angular_velocity = state.angular_velocities.col(Index(row))};
    const Body& body = bodies_[Index(row)];
    StorePose(row, MovedBy(free, step_size, body.mass.center_of_mass, body.pose), state);
  }
  for (ContactPoint& point : contacts.points) {
    point.normal_impulse = 0;
    point.friction_impulse.setZero();
  }
  for (uint32_t island = 0; island < islands_.islands().size(); ++island) {
    double softness = 1;
    const bool is_exact = IsExact(island, state, contacts, joint_rows, softness);
    if (is_exact) most_exact_ = std::max(most_exact_, static_cast<uint32_t>(islands_.RowsOf(island).size()));
    if (!is_exact || !SolveExactly(island, softness, step_size, state, contacts, joint_rows)) {
      Sweep(island, step_size, state, contacts, joint_rows);
    }
  }
}

void World::SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                       std::span<JointRow> joint_rows) {
  ContactMemory kept = std::exchange(memory_, memory_.OfBefore());
  SolveIslands(step_size, rows, state, contacts, joint_rows);
  memory_ = std::move(kept);
}

ContactMemory::Motion World::MemoryMotionOf(EntityId id) const {
  const EntityRow row{id.index()};
  if (!IsBody(row) || bodies_[Index(row)].id != id) return ContactMemory::Motion::kGone;
  if (bodies_[Index(row)].motion_type == MotionType::kStatic) return ContactMemory::Motion::kNone;
  return bodies_[Index(row)].is_active ? ContactMemory::Motion::kMoving : ContactMemory::Motion::kResting;
}

// In the frame of what slides over the other its points stand still.
std::pair<ContactMemory::Key, Placement> World::Identify(const ContactPair& pair) {
  const Body &a = bodies_[Index(pair.entity_a)], &b = bodies_[Index(pair.entity_b)];
  const GeometryRow frame = b.motion_type == MotionType::kDynamic ? pair.geometry_b : pair.geometry_a;
  PlaceMoved(frame);
  return {{a.id, b.id, shapes_[Index(pair.geometry_a)].id(), shapes_[Index(pair.geometry_b)].id()},
          shapes_[Index(frame)].placement()};
}

void World::Recall(const ContactBuffer& solved) {
  memory_.Recall(
      solved, [&](const ContactPair& pair) { return Identify(pair); },
      [&](const ContactPair& pair, std::vector<ContactPoint>& points) {
        FindPoints(pair.geometry_a, pair.geometry_b, points);
      });
}

void World::SaveState(std::string& bytes) const {
  memory_.Save(bytes);
  bytes.push_back(has_failed_exactly_ ? 1 : 0);
}

void World::Sweep(uint32_t number, double step_size, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) {
  const Islands::Island& island = islands_.islands()[number];
  const bool are_few = island.contacts <= ContactSweeps::kFewPoints && island.joint_rows == 0;
  sweeps_.Begin(step_size, contacts.pull, are_few);
  for (const EntityRow row : islands_.RowsOf(number))
    bodies_[Index(row)].solved_as = sweeps_.AddBody(Swept(row, state));
  for (const uint32_t i : islands_.PairsOf(number)) {
    const ContactPair& pair = contacts.pairs[i];
    ContactMemory::PerPoint<PointImpulse>& impulses = memory_.pairs()[i].impulses;
    sweeps_.AddPair(NumberOf(pair.entity_a, state), NumberOf(pair.entity_b, state), pair, PointsOf(pair, contacts),
                    {impulses.data(), impulses.size()});
  }
  for (const uint32_t i : islands_.JointRowsOf(number)) {
    JointRow& row = joint_rows[i];
    sweeps_.AddRow(NumberOf(row.a, state), NumberOf(row.b, state), row);
  }
  sweeps_.Solve(false);
  for (const EntityRow row : islands_.RowsOf(number)) {
    Body& body = bodies_[Index(row)];
    const SweptBody& swept = sweeps_.body(std::exchange(body.solved_as, kUnsolved));
    state.linear_velocities.col(Index(row)) = swept.linear_velocity;
    state.angular_velocities.col(Index(row)) = swept.angular_velocity;
    StorePose(row, MovedBy(swept, step_size, body.mass.center_of_mass, body.pose), state);
    CheckFinite(row, state);
  }
  for (const EntityRow row : driven_) bodies_[Index(row)].solved_as = kUnsolved;
  driven_.clear();
}

SweptBody World::Swept(EntityRow row, const StateArrays& state) const {
  const Body& body = bodies_[Index(row)];
  const Motion motion = MotionOf(row, state);
  SweptBody swept{.is_dynamic = body.motion_type == MotionType::kDynamic,
                  .center = motion.position,
                  .linear_velocity = motion.linear_velocity,
                  .angular_velocity = motion.angular_velocity};
  if (!swept.is_dynamic) return swept;
  const Matrix3 rotation = body.pose.orientation.toRotationMatrix();
  swept.inverse_mass = 1 / body.mass.mass;
  swept.inverse_tensor = rotation * (body.mass.inverse_tensor / body.inertia_factor) * rotation.transpose();
  return swept;
}

// The world, entities without physics, and what does not move are one.
uint32_t World::NumberOf(EntityRow row, const StateArrays& state) {
  if (!IsBody(row)) return ContactSweeps::kFixed;
  Body& body = bodies_[Index(row)];
  if (body.solved_as == kUnsolved && body.motion_type == MotionType::kKinematic && body.is_active) {
    body.solved_as = sweeps_.AddBody(Swept(row, state));
    driven_.push_back(row);
  }
  return body.solved_as == kUnsolved ? ContactSweeps::kFixed : body.solved_as;
}

Motion World::MotionOf(EntityRow row, const StateArrays& state) const {
  const Body& body = bodies_[Index(row)];
  const uint32_t column = Index(row);
  return {body.is_centered ? body.pose.position : body.pose.Transform(body.mass.center_of_mass), body.pose.orientation,
          state.linear_velocities.col(column), state.angular_velocities.col(column)};
}

// Before a solve too: ODE itself notices in the middle of one, and then its memory for the step is lost.
void World::CheckFinite(EntityRow row, const StateArrays& state) const {
  if (!state.linear_velocities.col(Index(row)).allFinite() || !state.angular_velocities.col(Index(row)).allFinite()) {
    throw EngineFault("ODE: a velocity is not finite");
  }
}

void World::StorePose(EntityRow row, const Pose& pose, StateArrays& state) {
  state.set_pose(row, pose);
  Move(bodies_[Index(row)], pose);
}

}  // namespace genphys::ode_backend

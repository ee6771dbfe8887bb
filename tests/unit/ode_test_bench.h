#pragma once
#include <algorithm>
#include <memory>
#include <vector>

#include "core/src/pairs/near_pairs.h"
#include "genphys/backends/ode.h"

namespace genphys::ode_test {

constexpr double kGravity = 9.81;
constexpr double kStep = 1.0 / 120;
// ODE lets bodies rest this deep, and its iterations end near, not on, the solution.
constexpr double kRestError = 2e-5;
constexpr double kRounding = 1e-12;

/// A backend's world with the least of a layer around it: gravity, friction, and columns.
class Bench {
 public:
  explicit Bench(const StepperDesc& stepper = {})
      : backend_(MakeOdeBackend()), world_(backend_->CreateWorld(backend_->Resolve(stepper))) {}

  EntityRow Add(const RigidBody& body, const Pose& pose) {
    const EntityRow row{state.rows()};
    state.Resize(state.rows() + 1);
    const EntityId id(Index(row), 1);
    state.ids[Index(row)] = id;
    state.set_pose(row, pose);
    state.linear_velocities.col(Index(row)) = body.linear_velocity;
    state.angular_velocities.col(Index(row)) = body.angular_velocity;
    MassProperties mass;
    if (body.motion_type == MotionType::kDynamic) {
      mass = ComputeMassProperties(body).value();
      moving.push_back(row);
    }
    const auto geometries = rule.Add(row, id, body);
    world_->AddBody({.row = row, .id = id, .body = body, .mass = mass, .geometries = geometries}, state);
    near_.Add(rule, {body, geometries}, pose, true);
    bodies_.push_back({body, geometries});
    return row;
  }

  void Remove(EntityRow row) {
    world_->RemoveBody(row);
    near_.Remove(bodies_[Index(row)].geometries);
    rule.Remove(bodies_[Index(row)].geometries);
    std::erase(moving, row);
  }

  EntityRow Add(const Shape& shape, const Vector3& position, MotionType motion_type = MotionType::kDynamic) {
    return Add(BodyOf(shape, motion_type), {.position = position, .orientation = Quaternion::Identity()});
  }

  void AddGround() { Add(Plane{}, Vector3::Zero(), MotionType::kStatic); }

  static RigidBody BodyOf(const Shape& shape, MotionType motion_type = MotionType::kDynamic) {
    RigidBody body;
    body.motion_type = motion_type;
    Geometry geometry;
    geometry.id = 1;
    geometry.shape = shape;
    geometry.material = Filled(Material{}, Material{});
    body.geometries.push_back(geometry);
    return body;
  }

  void Collide() { near_.Collide(rule, *world_, contacts); }

  void Step(double h = kStep) {
    Collide();
    for (EntityRow row : moving) state.linear_velocities(2, Index(row)) -= gravity * h;
    for (const ContactPair& pair : contacts.pairs) {
      for (uint32_t i = 0; i < pair.point_count; ++i) contacts.points[pair.first_point + i].friction = friction;
    }
    world_->Solve(h, moving, state, contacts, {});
    PlaceAll();
  }

  void PlaceAll() {
    for (EntityRow row : moving) Place(row);
  }

  void Run(double seconds) {
    for (double t = 0; t < seconds; t += kStep) Step();
  }

  void SetActive(EntityRow row, bool active) {
    world_->SetActive({&row, 1}, active);
    near_.SetActive(member(row), active);
    std::erase(moving, row);
    if (active) moving.insert(std::lower_bound(moving.begin(), moving.end(), row), row);
  }

  void Move(EntityRow row, const Vector3& position) {
    state.positions.col(Index(row)) = position;
    world_->WriteState({&row, 1}, state);
    Place(row);
  }

  Vector3 position(EntityRow row) const { return state.positions.col(Index(row)); }
  Vector3 velocity(EntityRow row) const { return state.linear_velocities.col(Index(row)); }
  EntityId id(EntityRow row) const { return state.ids[Index(row)]; }
  BackendWorld& world() { return *world_; }

  StateArrays state;
  PairRule rule;
  ContactBuffer contacts;
  std::vector<EntityRow> moving;  // dynamic and active, ascending
  double gravity = kGravity;
  double friction = 0.5;

 private:
  struct Added {
    RigidBody body;
    GeometryRows geometries;
  };

  NearPairs::Member member(EntityRow row) const { return {bodies_[Index(row)].body, bodies_[Index(row)].geometries}; }
  void Place(EntityRow row) { near_.Place(member(row), state.pose(row)); }

  std::unique_ptr<Backend> backend_;
  std::unique_ptr<BackendWorld> world_;
  NearPairs near_;
  std::vector<Added> bodies_;  // by row
};

const Box kUnitBox{{0.5, 0.5, 0.5}};
const Sphere kUnitBall{0.5};

}  // namespace genphys::ode_test

#pragma once
#include <algorithm>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "core/src/pairs/near_pairs.h"
#include "genphys/backends/bullet.h"

namespace genphys::bullet_test {

constexpr double kGravity = 9.81;
constexpr double kStep = 1.0 / 120;

/// A world of the engine and what a layer must do at least: it adds gravity, names coefficients of friction and steps.
struct Bench {
  explicit Bench(const StepperDesc& stepper = {})
      : backend(MakeBulletBackend()), world(backend->CreateWorld(backend->Resolve(stepper))) {}

  EntityRow Add(const RigidBody& body, const Pose& pose = {}) {
    const EntityRow row{state.rows()};
    state.Resize(state.rows() + 1);
    AddAt(row, EntityId(Index(row), 1), body, pose);
    return row;
  }

  void AddAt(EntityRow row, EntityId id, const RigidBody& body, const Pose& pose) {
    const bool is_dynamic = body.motion_type == MotionType::kDynamic;
    const MassProperties mass = is_dynamic ? ComputeMassProperties(body).value() : MassProperties{};
    state.ids[Index(row)] = id;
    state.set_pose(row, pose);
    state.linear_velocities.col(Index(row)) = body.linear_velocity;
    state.angular_velocities.col(Index(row)) = body.angular_velocity;
    const GeometryRows geometries = rule.Add(row, id, body);
    world->AddBody({.row = row, .id = id, .body = body, .mass = mass, .geometries = geometries}, state);
    near.Add(rule, {body, geometries}, pose, true);
    bodies.resize(state.rows());
    bodies[Index(row)] = {body, geometries};
    if (is_dynamic) SetMoving(row, true);
  }

  EntityRow Add(const Shape& shape, const Vector3& position, MotionType motion_type = MotionType::kDynamic) {
    return Add(Describe(shape, motion_type), {position, Quaternion::Identity()});
  }

  static RigidBody Describe(const Shape& shape, MotionType motion_type = MotionType::kDynamic) {
    RigidBody body;
    body.motion_type = motion_type;
    body.geometries.push_back({.id = 1, .shape = shape, .material = Filled(Material{}, Material{})});
    return body;
  }

  void Remove(EntityRow row) {
    world->RemoveBody(row);
    near.Remove(bodies[Index(row)].geometries);
    rule.Remove(bodies[Index(row)].geometries);
    SetMoving(row, false);
  }

  void SetActive(EntityRow row, bool active) {
    world->SetActive({&row, 1}, active);
    near.SetActive(member(row), active);
    SetMoving(row, active);
  }

  void Put(EntityRow row, const Pose& pose) {
    state.set_pose(row, pose);
    world->WriteState({&row, 1}, state);
    Place(row);
  }

  void Collide() { near.Collide(rule, *world, contacts); }

  /// Solves for `h` seconds what the last Collide() found, under gravity.
  void Solve(double h = kStep) {
    for (const EntityRow row : moving) state.linear_velocities.col(Index(row)) += h * gravity;
    for (ContactPoint& point : contacts.points) point.friction = friction;
    world->Solve(h, moving, state, contacts, {});
    for (const EntityRow row : moving) Place(row);
  }

  void Run(int steps, double h = kStep) {
    for (int i = 0; i < steps; ++i) {
      Collide();
      Solve(h);
    }
  }

  double NormalImpulse() const {
    double sum = 0;
    for (const ContactPoint& point : contacts.points) sum += point.normal_impulse;
    return sum;
  }

  double Mass(const Shape& shape) const { return ComputeMassProperties(Describe(shape)).value().mass; }
  std::string Saved() const {
    std::string bytes;
    world->SaveState(bytes);
    return bytes;
  }
  Vector3 position(EntityRow row) const { return state.positions.col(Index(row)); }
  Vector3 velocity(EntityRow row) const { return state.linear_velocities.col(Index(row)); }
  Vector3 spin(EntityRow row) const { return state.angular_velocities.col(Index(row)); }
  EntityId id(EntityRow row) const { return state.ids[Index(row)]; }

  struct Added {
    RigidBody body;
    GeometryRows geometries;
  };

  std::unique_ptr<Backend> backend;
  std::unique_ptr<BackendWorld> world;
  NearPairs near;
  std::vector<Added> bodies;  // by row
  StateArrays state;
  PairRule rule;
  ContactBuffer contacts;
  std::vector<EntityRow> moving;  // dynamic and active, ascending
  Vector3 gravity{0, 0, -kGravity};
  double friction = 0.5;

 private:
  NearPairs::Member member(EntityRow row) const { return {bodies[Index(row)].body, bodies[Index(row)].geometries}; }
  void Place(EntityRow row) { near.Place(member(row), state.pose(row)); }
  void SetMoving(EntityRow row, bool is_moving) {
    std::erase(moving, row);
    if (is_moving) moving.insert(std::lower_bound(moving.begin(), moving.end(), row), row);
  }
};

inline Quaternion TurnedBy(double angle, const Vector3& axis) {
  return Quaternion(Eigen::AngleAxisd(angle, axis.normalized()));
}

inline const Box kUnitBox{{0.5, 0.5, 0.5}};
inline const Sphere kUnitBall{0.5};
inline const Plane kGround{};

}  // namespace genphys::bullet_test

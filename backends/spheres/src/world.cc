#include "world.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "genphys/contact_sweeps.h"

namespace genphys::spheres_backend {
namespace {

ContactPoint Between(const Sphere& a, const Pose& pose_a, const Sphere& b, const Pose& pose_b) {
  const Vector3 apart = pose_b.position - pose_a.position;
  const double distance = apart.norm();
  // Of two at one place each direction is as good.
  const Vector3 normal = distance > 0 ? Vector3(apart / distance) : Vector3(Vector3::UnitZ());
  const double depth = a.radius + b.radius - distance;
  return {.position = pose_a.position + (a.radius - depth / 2) * normal, .normal = normal, .depth = depth};
}

ContactPoint Between(const Plane& plane, const Pose& pose_a, const Sphere& b, const Pose& pose_b) {
  const Vector3 normal = pose_a.orientation * plane.normal;
  const double height = normal.dot(pose_b.position - pose_a.position) - plane.offset;
  const double depth = b.radius - height;
  return {.position = pose_b.position - (b.radius - depth / 2) * normal, .normal = normal, .depth = depth};
}

// From a to b; nothing for two planes.
std::optional<ContactPoint> Meet(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  const Sphere* sphere_a = std::get_if<Sphere>(&a);
  const Sphere* sphere_b = std::get_if<Sphere>(&b);
  if (sphere_a != nullptr && sphere_b != nullptr) return Between(*sphere_a, pose_a, *sphere_b, pose_b);
  if (sphere_b != nullptr) return Between(std::get<Plane>(a), pose_a, *sphere_b, pose_b);
  if (sphere_a == nullptr) return std::nullopt;
  ContactPoint point = Between(std::get<Plane>(b), pose_b, *sphere_a, pose_a);
  point.normal = -point.normal;
  return point;
}

}  // namespace

void World::AddBody(const BodyDesc& desc, const StateArrays& state) {
  bodies_.insert_or_assign(desc.row, Body{.mass = desc.mass, .pose = state.pose(desc.row)});
  for (size_t i = 0; i < desc.geometries.size(); ++i) {
    const Geometry& geometry = desc.body.geometries[i];
    parts_.insert_or_assign(desc.geometries[i], Part{desc.row, geometry.shape, geometry.pose_in_entity});
  }
}

void World::WriteState(std::span<const EntityRow> rows, const StateArrays& state) {
  for (const EntityRow row : rows) bodies_.at(row).pose = state.pose(row);
}

void World::FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) {
  const auto& [row_a, shape_a, pose_a] = parts_.at(a);
  const auto& [row_b, shape_b, pose_b] = parts_.at(b);
  const std::optional<ContactPoint> point =
      Meet(shape_a, bodies_.at(row_a).pose.Transform(pose_a), shape_b, bodies_.at(row_b).pose.Transform(pose_b));
  if (point && point->depth >= kTouchingDepth) points.push_back(*point);
}

void World::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow>) {
  ContactSolver solver(state);
  for (const EntityRow row : rows) solver.AddMover(row, bodies_.at(row).mass);
  for (const ContactPair& pair : contacts.pairs) {
    ContactPoint& point = contacts.points[pair.first_point];
    if (!pair.is_sensor && !point.is_ahead) solver.AddContact(pair, point);
  }
  solver.Solve(step_size, settings_.iterations);
  for (const EntityRow row : rows) {
    Body& body = bodies_.at(row);
    const auto& [velocity, spin, push, turn] = solver.MotionOf(row);
    state.linear_velocities.col(Index(row)) = velocity;
    state.angular_velocities.col(Index(row)) = spin;
    const SweptBody moved{.linear_velocity = velocity, .angular_velocity = spin, .push = push, .turn = turn};
    body.pose = MovedBy(moved, step_size, body.mass.center_of_mass, body.pose);
    state.set_pose(row, body.pose);
  }
}

}  // namespace genphys::spheres_backend

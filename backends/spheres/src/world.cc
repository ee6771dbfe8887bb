#include "world.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "genphys/ray_cast.h"

namespace genphys::spheres_backend {
namespace {

// The orientation after `time` seconds of constant `spin`: the exponential map, exact and of unit length.
Quaternion Turned(const Quaternion& orientation, const Vector3& spin, double time) {
  const double angle = spin.norm() * time;
  if (angle == 0) return orientation;
  return (Eigen::AngleAxisd(angle, spin.normalized()) * orientation).normalized();
}

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
  Body body{.mass = desc.mass, .is_static = desc.body.motion_type == MotionType::kStatic, .pose = state.pose(desc.row)};
  for (size_t i = 0; i < desc.geometries.size(); ++i) {
    const Geometry& geometry = desc.body.geometries[i];
    body.parts.push_back({desc.geometries[i], geometry.shape, geometry.pose_in_entity});
  }
  bodies_.insert_or_assign(desc.row, std::move(body));
}

void World::SetActive(std::span<const EntityRow> rows, bool active) {
  for (const EntityRow row : rows) bodies_.at(row).is_active = active;
}

void World::WriteState(std::span<const EntityRow> rows, const StateArrays& state) {
  for (const EntityRow row : rows) bodies_.at(row).pose = state.pose(row);
}

void World::CollideBodies(const PairRule& rule, EntityRow row_a, EntityRow row_b, ContactBuffer& contacts) const {
  for (const Part& part_a : bodies_.at(row_a).parts) {
    for (const Part& part_b : bodies_.at(row_b).parts) {
      const PairRule::Verdict verdict = rule.Decide(part_a.row, part_b.row);
      if (verdict == PairRule::Verdict::kIgnore) continue;
      // The smaller id comes first, whatever the rows.
      const bool in_order = rule.Before(part_a.row, part_b.row);
      const Part& first = in_order ? part_a : part_b;
      const Part& second = in_order ? part_b : part_a;
      const EntityRow first_row = in_order ? row_a : row_b, second_row = in_order ? row_b : row_a;
      const std::optional<ContactPoint> point =
          Meet(first.shape, bodies_.at(first_row).pose.Transform(first.pose_in_entity), second.shape,
               bodies_.at(second_row).pose.Transform(second.pose_in_entity));
      if (!point || point->depth < kTouchingDepth) continue;
      contacts.pairs.push_back({.entity_a = first_row,
                                .entity_b = second_row,
                                .geometry_a = first.row,
                                .geometry_b = second.row,
                                .material = rule.Mixed(first.row, second.row),
                                .is_sensor = verdict == PairRule::Verdict::kSensor,
                                .first_point = static_cast<uint32_t>(contacts.points.size()),
                                .point_count = 1});
      contacts.points.push_back(*point);
    }
  }
}

void World::Collide(const PairRule& rule, ContactBuffer& contacts) {
  contacts.Clear();
  for (auto a = bodies_.begin(); a != bodies_.end(); ++a) {
    for (auto b = std::next(a); b != bodies_.end(); ++b) {
      const auto moves = [](const Body& body) { return body.is_active && !body.is_static; };
      if (moves(a->second) || moves(b->second)) CollideBodies(rule, a->first, b->first, contacts);
    }
  }
  std::sort(contacts.pairs.begin(), contacts.pairs.end(), [&](const ContactPair& a, const ContactPair& b) {
    const auto key = [&](const ContactPair& pair) {
      const auto& info_a = rule.info(pair.geometry_a);
      const auto& info_b = rule.info(pair.geometry_b);
      return std::tuple(info_a.entity_id, info_b.entity_id, info_a.geometry_id, info_b.geometry_id);
    };
    return key(a) < key(b);
  });
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
    const Quaternion orientation = Turned(body.pose.orientation, spin + turn, step_size);
    // The centre of mass goes straight on, and the frame of the entity turns about it.
    const Vector3& center = body.mass.center_of_mass;
    const Vector3 swing = body.pose.orientation * center - orientation * center;
    body.pose = {body.pose.position + swing + step_size * (velocity + push), orientation};
    state.set_pose(row, body.pose);
  }
}

std::vector<GeometryRow> World::AllRows() const {
  std::vector<GeometryRow> rows;
  for (const auto& [row, body] : bodies_) {
    for (const Part& part : body.parts) rows.push_back(part.row);
  }
  return rows;
}

void World::CastRays(const PairRule& rule, std::span<const Ray> rays, uint64_t collides_with_bits,
                     std::span<RayHit> hits) {
  for (size_t i = 0; i < rays.size(); ++i) {
    hits[i] = RayHit{};
    for (const auto& [row, body] : bodies_) {
      for (const Part& part : body.parts) {
        if (!rule.SeenByRay(part.row, collides_with_bits)) continue;
        const Pose pose = body.pose.Transform(part.pose_in_entity);
        const Quaternion back = pose.orientation.conjugate();
        const std::optional<SurfaceHit> hit =
            EnterShape(part.shape, {back * (rays[i].origin - pose.position), back * rays[i].translation});
        if (!hit) continue;
        const EntityId id = rule.info(part.row).entity_id;
        const bool is_nearer =
            hits[i].entity.is_null() || std::tie(hit->fraction, id) < std::tie(hits[i].fraction, hits[i].entity);
        if (is_nearer) hits[i] = {id, hit->fraction, pose.orientation * hit->normal};
      }
    }
  }
}

// Some more than there are may be told, and all is some more.
void World::FindOnSegment(const Ray&, std::vector<GeometryRow>& found) {
  const std::vector<GeometryRow> rows = AllRows();
  found.insert(found.end(), rows.begin(), rows.end());
}

void World::FindInBounds(const Bounds&, std::vector<GeometryRow>& found) {
  const std::vector<GeometryRow> rows = AllRows();
  found.insert(found.end(), rows.begin(), rows.end());
}

}  // namespace genphys::spheres_backend

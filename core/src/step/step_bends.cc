// How surfaces that touch run against each other because their bodies turn. Contacts are solved for velocities at
// points where these are when a substep begins, and by its middle the points have turned on: what is held there at
// every beginning creeps outward by half of omega^2 r h. So solves are told how the slip changes until the middle, and
// hold or rub what slips on the mean.
#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "pairs/contact_points.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// rad in a substep: who turns less bends no way.
constexpr double kNoTurn = 1e-4;
// Cosine between the axis of something round and the normal: it rolls unless it stands on an end.
constexpr double kOnEnd = 0.9;

// s: how long a velocity that turns by `spin` has to be led across it to become its mean in `h` seconds. Half of them,
// while that turns it little.
double TimeOfBend(const Vector3& spin, double h) {
  constexpr double kLittle = 0.1;  // rad
  const double square = spin.squaredNorm() * (h * h);
  return square < kLittle * kLittle ? h * (0.5 - square / 24) : h * (1 - std::cos(std::sqrt(square))) / square;
}

// In the frame of a shape: about which point it is round at `point` where `normal` is that of its surface, if it is.
struct Roundness {
  Vector3 point;
  Vector3 normal;

  std::optional<Vector3> AboutAxis() const {
    if (std::abs(normal.z()) > kOnEnd) return std::nullopt;
    return Vector3(0, 0, point.z());
  }
  std::optional<Vector3> operator()(const Sphere&) const { return Vector3(Vector3::Zero()); }
  std::optional<Vector3> operator()(const Ellipsoid&) const { return Vector3(Vector3::Zero()); }
  std::optional<Vector3> operator()(const Capsule& capsule) const {
    return Vector3(0, 0, std::clamp(point.z(), -capsule.half_length, capsule.half_length));
  }
  std::optional<Vector3> operator()(const Cylinder&) const { return AboutAxis(); }
  std::optional<Vector3> operator()(const Cone&) const { return AboutAxis(); }
  std::optional<Vector3> operator()(const auto&) const { return std::nullopt; }
};

}  // namespace

// About which point (m, world) a geometry is round where it touches something, if it is.
std::optional<Vector3> StepRun::CurvedAbout(EntityRow entity, GeometryRow row, const ContactPoint& point) const {
  const GeometryRows& rows = world_.geometry_rows_[Index(entity)];
  const auto place = static_cast<size_t>(std::find(rows.begin(), rows.end(), row) - rows.begin());
  const Geometry& geometry = world_.scene_.entities[Index(entity)]->desc->rigid_body->geometries[place];
  const Pose pose = state_.pose(entity).Transform(geometry.pose_in_entity);
  const Quaternion back = pose.orientation.conjugate();
  const std::optional<Vector3> center =
      std::visit(Roundness{back * (point.position - pose.position), back * point.normal}, geometry.shape);
  return center ? std::optional<Vector3>(pose.Transform(*center)) : std::nullopt;
}

// m/s, by how much more than at its beginning b slips against a on the mean of a substep, where they touch at a point.
Vector3 StepRun::RolledBend(const ContactPair& pair, const ContactPoint& point, double h) const {
  struct Side {
    Vector3 velocity, spin;
    Vector3 at_point;               // m/s, of what it is made of
    std::optional<Vector3> course;  // m/s, of where it touches, as far as that is for it to say
    double radius = 0;
  };
  const auto side_of = [&](EntityRow entity, GeometryRow geometry) {
    const Vector3 center = CenterOf(entity);
    Side side{.velocity = state_.linear_velocities.col(Index(entity)),
              .spin = state_.angular_velocities.col(Index(entity)),
              .at_point = VelocityAt(entity, center, point.position)};
    if (const std::optional<Vector3> about = CurvedAbout(entity, geometry, point)) {
      side.course = VelocityAt(entity, center, *about);
      side.radius = (point.position - *about).norm();
    }
    return side;
  };
  const Side a = side_of(pair.entity_a, pair.geometry_a), b = side_of(pair.entity_b, pair.geometry_b);
  // Where two that are flat touch stays with both of them. What is round takes it along over what is flat.
  std::optional<Vector3> course = a.course ? a.course : b.course;
  if (a.course && b.course) {
    // The middle of both may be that point.
    const double both = a.radius + b.radius, part = both > 0 ? a.radius / both : 0.5;
    course = part * *b.course + (1 - part) * *a.course;
  }
  const auto change = [&](const Side& side) -> Vector3 {
    Vector3 way = side.at_point - side.velocity;
    if (course) way += Across(*course - side.at_point, point.normal);
    return TimeOfBend(side.spin, h) * side.spin.cross(way);
  };
  return change(b) - change(a);
}

// The same of two that are flat, at the middle of their points.
Vector3 StepRun::FlatBend(const ContactPair& pair, double h) const {
  Vector3 middle = Vector3::Zero();
  for (const ContactPoint& point : PointsOf(world_.contacts_, pair)) middle += point.position / pair.point_count;
  const auto change = [&](EntityRow entity) -> Vector3 {
    const Vector3 spin = state_.angular_velocities.col(Index(entity));
    return TimeOfBend(spin, h) * spin.cross(spin.cross(middle - CenterOf(entity)));
  };
  return change(pair.entity_b) - change(pair.entity_a);
}

// Of all pairs, while velocities are those at the beginning: what pushes until the middle may be held.
void StepRun::FindBends(double h) {
  const auto turns = [&](EntityRow row) {
    return state_.angular_velocities.col(Index(row)).squaredNorm() * (h * h) > kNoTurn * kNoTurn;
  };
  const auto is_smooth = [](const MixedMaterial& material) {
    return material.friction == 0 && material.kinetic_friction == 0;
  };
  scratch_.bends.clear();
  for (const ContactPair& pair : world_.contacts_.pairs) {
    Vector3& bend = scratch_.bends.emplace_back(Vector3::Zero());
    if (pair.is_sensor || is_smooth(pair.material) || !(turns(pair.entity_a) || turns(pair.entity_b))) continue;
    if (!world_.rule_.info(pair.geometry_a).rolls && !world_.rule_.info(pair.geometry_b).rolls) {
      bend = FlatBend(pair, h);
      continue;
    }
    for (const ContactPoint& point : PointsOf(world_.contacts_, pair)) {
      bend += RolledBend(pair, point, h) / pair.point_count;
    }
  }
}

}  // namespace genphys

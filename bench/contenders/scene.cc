#include "scene.h"

#include <algorithm>
#include <stdexcept>

namespace genphys::bench {
namespace {

Pose InFrameOf(const Pose& frame, const Pose& world) {
  const Quaternion back = frame.orientation.conjugate();
  return {back * (world.position - frame.position), (back * world.orientation).normalized()};
}

}  // namespace

size_t Scene::Add(const Shape& shape, double mass, const Pose& pose, const Vector3& velocity, const Vector3& spin) {
  RigidBody body;
  body.geometries.push_back({.shape = shape});
  body.inertia.mass = mass;
  body.linear_velocity = velocity;
  body.angular_velocity = spin;
  bodies.push_back({.pose = pose, .rigid_body = body});
  return bodies.size() - 1;
}

size_t Scene::AddStatic(const Shape& shape, const Pose& pose) {
  RigidBody body{.motion_type = MotionType::kStatic};
  body.geometries.push_back({.shape = shape});
  bodies.push_back({.pose = pose, .rigid_body = body});
  return bodies.size() - 1;
}

size_t Scene::Join(const JointKind& kind, std::optional<size_t> a, size_t b, const Vector3& anchor,
                   const Vector3& axis) {
  const Pose frame{anchor, Quaternion::FromTwoVectors(Vector3::UnitZ(), axis)};
  JointDesc joint{.frame_in_a = frame, .frame_in_b = InFrameOf(bodies.at(b).pose, frame), .kind = kind};
  if (a) {
    joint.entity_a.created_by_command = static_cast<uint32_t>(*a);
    joint.frame_in_a = InFrameOf(bodies.at(*a).pose, frame);
  }
  joint.entity_b.created_by_command = static_cast<uint32_t>(b);
  joints.push_back(joint);
  return joints.size() - 1;
}

std::optional<size_t> PlaceOf(const EntityRef& ref) {
  if (!ref.created_by_command) return std::nullopt;
  return size_t{*ref.created_by_command};
}

bool IsPlain(JointKind kind) {
  if (const auto* ball = std::get_if<BallJoint>(&kind)) return *ball == BallJoint{};
  const std::vector<JointAxis*> axes = AxesOf(kind);
  return std::all_of(axes.begin(), axes.end(), [](const JointAxis* axis) { return *axis == JointAxis{}; });
}

MassProperties MassOf(const EntityDesc& body) {
  constexpr double kOffCenterMax = 1e-12;  // m: what adding up a hull's faces leaves
  RigidBody filled = *body.rigid_body;
  for (Geometry& geometry : filled.geometries) geometry.material = Filled(geometry.material, {});
  const Result<MassProperties> mass = ComputeMassProperties(filled);
  if (!mass.ok()) throw std::logic_error(std::string(mass.status().message()));
  if (mass->center_of_mass.norm() > kOffCenterMax) throw std::logic_error("a body that is not about its centre");
  return *mass;
}

Pose At(double x, double y, double z) { return {.position = {x, y, z}}; }

Quaternion Turn(double angle, const Vector3& axis) { return Quaternion(Eigen::AngleAxisd(angle, axis)); }

}  // namespace genphys::bench

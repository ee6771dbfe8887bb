#include "scene_json.h"

#include <array>
#include <cstdio>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <variant>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"

namespace genphys::bench {
namespace {

template <typename Numbers>
std::string List(const Numbers& numbers) {
  std::string text = "[";
  for (const double number : numbers) text += (text.size() > 1 ? "," : "") + Exact(number);
  return text + ']';
}

std::string List(const std::vector<Vector3>& points) {
  std::string text = "[";
  for (const Vector3& point : points) text += (text.size() > 1 ? "," : "") + List(point);
  return text + ']';
}

std::string PoseMembers(const Pose& pose) {
  const Quaternion& q = pose.orientation;
  return "\"position\":" + List(pose.position) + ",\"orientation\":" + List(std::array{q.w(), q.x(), q.y(), q.z()});
}

struct ShapeWriter {
  std::string operator()(const Sphere& s) const { return "{\"kind\":\"sphere\",\"radius\":" + Exact(s.radius) + '}'; }
  std::string operator()(const Box& b) const {
    return "{\"kind\":\"box\",\"half_extents\":" + List(b.half_extents) + '}';
  }
  std::string operator()(const Capsule& c) const { return Round("capsule", c.radius, c.half_length); }
  std::string operator()(const Cylinder& c) const { return Round("cylinder", c.radius, c.half_length); }
  std::string operator()(const Plane& p) const {
    return "{\"kind\":\"plane\",\"normal\":" + List(p.normal) + ",\"offset\":" + Exact(p.offset) + '}';
  }
  std::string operator()(const ConvexHull& hull) const {
    return "{\"kind\":\"hull\",\"points\":" + List(hull.data->vertices) + '}';
  }
  std::string operator()(const TriangleMesh& mesh) const {
    return "{\"kind\":\"mesh\",\"points\":" + List(mesh.data->vertices) + ",\"indices\":" + List(mesh.data->indices) +
           '}';
  }
  template <typename Other>
  std::string operator()(const Other&) const {
    throw std::runtime_error("no problem has this shape");
  }

 private:
  static std::string Round(const std::string& kind, double radius, double half_length) {
    return "{\"kind\":\"" + kind + "\",\"radius\":" + Exact(radius) + ",\"half_length\":" + Exact(half_length) + '}';
  }
};

std::string BodyJson(const EntityDesc& body) {
  const RigidBody& rigid = *body.rigid_body;
  std::string text = "{\"shape\":" + std::visit(ShapeWriter(), rigid.geometries.at(0).shape) + ',' +
                     PoseMembers(body.pose) + ",\"velocity\":" + List(rigid.linear_velocity) +
                     ",\"spin\":" + List(rigid.angular_velocity);
  if (rigid.motion_type == MotionType::kStatic) return text + ",\"mass\":null}";
  const MassProperties mass = MassOf(body);
  const Matrix3& t = mass.tensor;
  return text + ",\"mass\":" + Exact(mass.mass) +
         ",\"tensor\":" + List(std::array{t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(0, 2), t(1, 2)}) + '}';
}

std::string JointJson(const JointDesc& joint) {
  if (!IsPlain(joint.kind)) throw std::runtime_error("peers are asked for no springs, motors and limits of joints");
  const char* kind = std::holds_alternative<BallJoint>(joint.kind)     ? "ball"
                     : std::holds_alternative<HingeJoint>(joint.kind)  ? "hinge"
                     : std::holds_alternative<SliderJoint>(joint.kind) ? "slider"
                                                                       : nullptr;
  if (kind == nullptr) throw std::runtime_error("no problem has this joint");
  const std::optional<size_t> a = PlaceOf(joint.entity_a);
  return std::string("{\"kind\":\"") + kind + "\",\"a\":" + (a ? std::to_string(*a) : "null") +
         ",\"b\":" + std::to_string(*PlaceOf(joint.entity_b)) + ",\"in_a\":{" + PoseMembers(*joint.frame_in_a) +
         "},\"in_b\":{" + PoseMembers(*joint.frame_in_b) + "}}";
}

}  // namespace

std::string Exact(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", number);
  return text.data();
}

std::string ToJson(const Scene& scene) {
  if (scene.may_sleep) throw std::runtime_error("peers are not asked to let anybody sleep");
  std::ostringstream out;
  out << "{\"gravity\":" << List(scene.gravity) << ",\"ground\":" << (scene.has_ground ? "true" : "false")
      << ",\"friction\":" << Exact(scene.friction) << ",\"restitution\":" << Exact(scene.restitution)
      << ",\"bodies\":[";
  const char* separator = "";
  for (const EntityDesc& body : scene.bodies) out << std::exchange(separator, ",") << BodyJson(body);
  out << "],\"joints\":[";
  separator = "";
  for (const JointDesc& joint : scene.joints) out << std::exchange(separator, ",") << JointJson(joint);
  out << "]}";
  return out.str();
}

}  // namespace genphys::bench

#include <string>
#include <utility>

#include "enums.h"
#include "genphys/convex_hull.h"
#include "genphys/surface.h"
#include "genphys/wire/decode.h"
#include "material_fields.h"
#include "values.h"

namespace genphys {
namespace {

Box DecodeBox(const v1::Box& box) { return box.has_half_extents() ? Box{DecodeVector(box.half_extents())} : Box{}; }

template <typename Round, typename Message>
Round DecodeRound(const Message& message) {
  Round round;
  if (message.has_radius()) round.radius = message.radius();
  if (message.has_half_length()) round.half_length = message.half_length();
  return round;
}

Plane DecodePlane(const v1::Plane& plane) {
  Plane decoded{.offset = plane.offset()};
  if (plane.has_normal()) decoded.normal = DecodeVector(plane.normal());
  return decoded;
}

std::vector<Vector3> DecodePoints(const google::protobuf::RepeatedField<double>& numbers) {
  std::vector<Vector3> points;
  points.reserve(static_cast<size_t>(numbers.size()) / 3);
  for (int i = 0; i + 2 < numbers.size(); i += 3) points.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return points;
}

Result<Shape> DecodeHull(const v1::ConvexHull& message) {
  Result<ConvexHull> hull = MakeConvexHull(DecodePoints(message.vertices()));
  if (!hull.ok()) return WithFieldPrefix(hull.status(), "convex_hull");
  return *std::move(hull);
}

Result<Shape> DecodeMesh(const v1::TriangleMesh& message) {
  Result<TriangleMesh> mesh =
      MakeTriangleMesh(DecodePoints(message.vertices()), {message.indices().begin(), message.indices().end()});
  if (!mesh.ok()) return WithFieldPrefix(mesh.status(), "triangle_mesh");
  return *std::move(mesh);
}

Result<Shape> DecodeHeightfield(const v1::Heightfield& message) {
  const double cell_size = message.has_cell_size() ? message.cell_size() : 1;
  Result<Heightfield> field = MakeHeightfield(message.rows(), message.columns(), cell_size,
                                              {message.heights().begin(), message.heights().end()});
  if (!field.ok()) return WithFieldPrefix(field.status(), "heightfield");
  return *std::move(field);
}

Result<Shape> DecodeShape(const v1::Shape& shape) {
  switch (shape.kind_case()) {
    case v1::Shape::kSphere:
      return shape.sphere().has_radius() ? Sphere{shape.sphere().radius()} : Sphere{};
    case v1::Shape::kBox:
      return DecodeBox(shape.box());
    case v1::Shape::kCapsule:
      return DecodeRound<Capsule>(shape.capsule());
    case v1::Shape::kCylinder:
      return DecodeRound<Cylinder>(shape.cylinder());
    case v1::Shape::kPlane:
      return DecodePlane(shape.plane());
    case v1::Shape::kConvexHull:
      return DecodeHull(shape.convex_hull());
    case v1::Shape::kTriangleMesh:
      return DecodeMesh(shape.triangle_mesh());
    case v1::Shape::kHeightfield:
      return DecodeHeightfield(shape.heightfield());
    case v1::Shape::kCone:
      return DecodeRound<Cone>(shape.cone());
    case v1::Shape::kEllipsoid:
      return shape.ellipsoid().has_semi_axes() ? Ellipsoid{DecodeVector(shape.ellipsoid().semi_axes())} : Ellipsoid{};
    case v1::Shape::KIND_NOT_SET:
      break;
  }
  return Refuse(Reason::kMissingField, "kind", "a shape says which form it is");
}

Result<Geometry> DecodeGeometry(const v1::Geometry& geometry) {
  Result<Shape> shape = DecodeShape(geometry.shape());
  if (!shape.ok()) return WithFieldPrefix(shape.status(), "shape");
  Geometry decoded{.id = geometry.id(),
                   .shape = *shape,
                   .pose_in_entity = DecodePose(geometry.pose_in_entity()),
                   .material = DecodeMaterial(geometry.material()),
                   .is_sensor = geometry.is_sensor(),
                   .collision_space = geometry.collision_space()};
  if (geometry.has_category_bits()) decoded.category_bits = geometry.category_bits();
  if (geometry.has_collides_with_bits()) decoded.collides_with_bits = geometry.collides_with_bits();
  return decoded;
}

InertiaDesc DecodeInertia(const v1::Inertia& inertia) {
  InertiaDesc decoded;
  if (inertia.has_mass()) decoded.mass = inertia.mass();
  if (inertia.has_center_of_mass()) decoded.center_of_mass = DecodeVector(inertia.center_of_mass());
  if (inertia.tensor_size() == 6) {
    const auto& t = inertia.tensor();
    decoded.tensor = Matrix3{{t[0], t[1], t[2]}, {t[1], t[3], t[4]}, {t[2], t[4], t[5]}};
  }
  return decoded;
}

Result<RigidBody> DecodeBody(const v1::RigidBody& body) {
  GENPHYS_RETURN_IF_ERROR(CheckErrorCorrection(body.error_correction()));
  RigidBody decoded{.motion_type = DecodeMotionType(body.motion_type()),
                    .inertia = DecodeInertia(body.inertia()),
                    .auto_disable = DecodeAutoDisable(body.auto_disable()),
                    .linear_velocity = DecodeVector(body.linear_velocity()),
                    .angular_velocity = DecodeVector(body.angular_velocity()),
                    .linear_damping = body.linear_damping(),
                    .angular_damping = body.angular_damping()};
  decoded.geometries.reserve(static_cast<size_t>(body.geometries_size()));
  for (int i = 0; i < body.geometries_size(); ++i) {
    Result<Geometry> geometry = DecodeGeometry(body.geometries(i));
    if (!geometry.ok()) return WithFieldPrefix(geometry.status(), "geometries[" + std::to_string(i) + "]");
    decoded.geometries.push_back(*std::move(geometry));
  }
  return decoded;
}

}  // namespace

Result<EntityDesc> DecodeEntity(const v1::Entity& entity) {
  EntityDesc decoded{.display_name = entity.display_name(), .pose = DecodePose(entity.pose())};
  if (entity.has_rigid_body()) {
    Result<RigidBody> body = DecodeBody(entity.rigid_body());
    if (!body.ok()) return WithFieldPrefix(body.status(), "rigid_body");
    decoded.rigid_body = *std::move(body);
  }
  if (entity.has_visual()) {
    const v1::Visual& visual = entity.visual();
    decoded.visual = Visual{visual.uri(), visual.media_type(), visual.data()};
  }
  return decoded;
}

Result<CreateEntity> DecodeCreate(const v1::Entity& entity) {
  Result<EntityDesc> desc = DecodeEntity(entity);
  if (!desc.ok()) return desc.status();
  return CreateEntity{*std::move(desc)};
}

}  // namespace genphys

#include "enums.h"
#include "genphys/convex_hull.h"
#include "genphys/surface.h"
#include "genphys/wire/encode.h"
#include "material_fields.h"
#include "values.h"

namespace genphys {
namespace {

struct ShapeEncoder {
  v1::Shape* out;

  void operator()(const Sphere& sphere) const { out->mutable_sphere()->set_radius(sphere.radius); }
  void operator()(const Box& box) const { EncodeVector(box.half_extents, out->mutable_box()->mutable_half_extents()); }
  void operator()(const Capsule& capsule) const {
    out->mutable_capsule()->set_radius(capsule.radius);
    out->mutable_capsule()->set_half_length(capsule.half_length);
  }
  void operator()(const Cylinder& cylinder) const {
    out->mutable_cylinder()->set_radius(cylinder.radius);
    out->mutable_cylinder()->set_half_length(cylinder.half_length);
  }
  void operator()(const Plane& plane) const {
    EncodeVector(plane.normal, out->mutable_plane()->mutable_normal());
    out->mutable_plane()->set_offset(plane.offset);
  }
  void operator()(const Cone& cone) const {
    out->mutable_cone()->set_radius(cone.radius);
    out->mutable_cone()->set_half_length(cone.half_length);
  }
  void operator()(const Ellipsoid& ellipsoid) const {
    EncodeVector(ellipsoid.semi_axes, out->mutable_ellipsoid()->mutable_semi_axes());
  }
  void operator()(const ConvexHull& hull) const {
    v1::ConvexHull& message = *out->mutable_convex_hull();
    if (hull.data != nullptr) AddPoints(hull.data->points, *message.mutable_vertices());
  }
  void operator()(const TriangleMesh& mesh) const {
    v1::TriangleMesh& message = *out->mutable_triangle_mesh();
    if (mesh.data == nullptr) return;
    AddPoints(mesh.data->vertices, *message.mutable_vertices());
    message.mutable_indices()->Add(mesh.data->indices.begin(), mesh.data->indices.end());
  }
  void operator()(const Heightfield& field) const {
    v1::Heightfield& message = *out->mutable_heightfield();
    if (field.data == nullptr) return;
    message.set_rows(field.data->rows);
    message.set_columns(field.data->columns);
    message.set_cell_size(field.data->cell_size);
    message.mutable_heights()->Add(field.data->heights.begin(), field.data->heights.end());
  }

  static void AddPoints(const std::vector<Vector3>& points, google::protobuf::RepeatedField<double>& out) {
    out.Reserve(static_cast<int>(3 * points.size()));
    for (const Vector3& point : points) out.Add(point.data(), point.data() + 3);
  }
};

void EncodeGeometry(const Geometry& geometry, v1::Geometry* out) {
  out->set_id(geometry.id);
  std::visit(ShapeEncoder{out->mutable_shape()}, geometry.shape);
  EncodePose(geometry.pose_in_entity, out->mutable_pose_in_entity());
  if (geometry.material != Material{}) EncodeMaterial(geometry.material, out->mutable_material());
  out->set_category_bits(geometry.category_bits);
  out->set_collides_with_bits(geometry.collides_with_bits);
  out->set_is_sensor(geometry.is_sensor);
  out->set_collision_space(geometry.collision_space);
}

void EncodeInertia(const InertiaDesc& inertia, v1::RigidBody* body) {
  if (!inertia.mass && !inertia.center_of_mass && !inertia.tensor) return;
  v1::Inertia* out = body->mutable_inertia();
  if (inertia.mass) out->set_mass(*inertia.mass);
  if (inertia.center_of_mass) EncodeVector(*inertia.center_of_mass, out->mutable_center_of_mass());
  if (!inertia.tensor) return;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) out->add_tensor((*inertia.tensor)(row, column));
  }
}

void EncodeBody(const RigidBody& body, v1::RigidBody* out) {
  out->set_motion_type(EncodeMotionType(body.motion_type));
  out->mutable_geometries()->Reserve(static_cast<int>(body.geometries.size()));
  for (const Geometry& geometry : body.geometries) EncodeGeometry(geometry, out->add_geometries());
  EncodeInertia(body.inertia, out);
  if (body.auto_disable != AutoDisable{}) EncodeAutoDisable(body.auto_disable, out->mutable_auto_disable());
  EncodeVector(body.linear_velocity, out->mutable_linear_velocity());
  EncodeVector(body.angular_velocity, out->mutable_angular_velocity());
  out->set_linear_damping(body.linear_damping);
  out->set_angular_damping(body.angular_damping);
}

}  // namespace

void EncodeEntity(EntityId id, const EntityDesc& desc, v1::Entity* out) {
  out->set_id(id.packed());
  out->set_display_name(desc.display_name);
  EncodePose(desc.pose, out->mutable_pose());
  if (desc.rigid_body) EncodeBody(*desc.rigid_body, out->mutable_rigid_body());
  if (!desc.visual) return;
  out->mutable_visual()->set_uri(desc.visual->uri);
  out->mutable_visual()->set_media_type(desc.visual->media_type);
  out->mutable_visual()->set_data(desc.visual->data);
}

}  // namespace genphys

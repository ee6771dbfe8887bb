#include "shape_message.h"

#include <utility>
#include <vector>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"
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

}  // namespace

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

void EncodeShape(const Shape& shape, v1::Shape* out) { std::visit(ShapeEncoder{out}, shape); }

}  // namespace genphys

#pragma once
#include <array>
#include <variant>

#include "absl/container/inlined_vector.h"
#include "genphys/placement.h"
#include "genphys/shape.h"
#include "shapes/surface_triangles.h"

namespace genphys {

/// The face, edge or corner with which a convex solid meets what lies in one direction.
struct SolidFeature {
  absl::InlinedVector<Vector3, 8> corners;  // of a polygon in order, the ends of a segment, or a point
  Vector3 normal = Vector3::Zero();         // of a polygon, outwards, unit length

  bool is_polygon() const { return corners.size() > 2; }
};

/// Two directions across a third one.
using AxesAcross = Eigen::Matrix<double, 3, 2>;

/// The point of a smooth piece of a surface that lies farthest in a direction, and how it moves along two axes across
/// that as it turns towards them, m/rad.
struct Farthest {
  Vector3 point;
  Eigen::Matrix2d slope;
};

/// A bounded convex solid at a place, as the narrow phase sees it: a core, rounded by a radius. Balls are rounded
/// points and capsules rounded segments; all others have no radius. What it was made of must outlive it.
class Solid {
 public:
  Solid(const Shape& shape, const Placement& placement);
  /// In the frame of its surface. It has no thickness.
  explicit Solid(const SurfaceTriangle& triangle);
  /// The triangle and all that lies straight below it, along z, down to `drop` m. Its features are those of the
  /// triangle.
  Solid(const SurfaceTriangle& triangle, double drop);

  /// The point of the core that lies farthest in `direction` (not zero, of any length).
  Vector3 Support(const Vector3& direction) const;
  /// How far the solid reaches along `direction` (unit length), rounding included.
  double Reach(const Vector3& direction) const { return direction.dot(Support(direction)) + radius_; }
  /// The same of the smooth piece of its surface on which `point` lies; `direction` is of unit length. What is not
  /// round has corners, which stay.
  Farthest Follow(const Vector3& point, const Vector3& direction, const AxesAcross& across) const;
  /// What of the core faces `direction` (unit length). A round rim is a polygon of which one corner lies farthest.
  SolidFeature FeatureAt(const Vector3& direction) const;

  /// Calls visit(direction) with normals of faces that may be the way out of an overlap with something at `other`.
  template <typename Visit>
  void VisitNormals(const Vector3& other, Visit&& visit) const {
    std::array<Vector3, kNormalsMax> normals;
    const size_t count = Normals(other, normals);
    for (size_t i = 0; i < count; ++i) visit(normals[i]);
  }

  /// Whether the core has other surfaces than flat ones.
  bool is_round() const { return is_round_; }
  double radius() const { return radius_; }
  const Vector3& center() const { return center_; }
  /// Half the least width, or about that; of a triangle its longest side.
  double size() const { return size_; }

 private:
  static constexpr size_t kNormalsMax = 64;

  size_t Normals(const Vector3& other, std::array<Vector3, kNormalsMax>& normals) const;

  const Shape* shape_ = nullptr;
  const SurfaceTriangle* triangle_ = nullptr;
  Placement placement_;
  Vector3 center_ = Vector3::Zero();
  double radius_ = 0;
  double size_ = 0;
  double drop_ = 0;  // of a triangle, m
  bool is_round_ = false;
};

}  // namespace genphys

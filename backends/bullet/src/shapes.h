#pragma once
#include <BulletCollision/CollisionShapes/btBoxShape.h>

#include <array>
#include <memory>

#include "convert.h"
#include "genphys/bounds.h"
#include "genphys/contact.h"
#include "genphys/shape.h"

namespace genphys::bullet_backend {

/// m: pairs with a larger gap have no contact point.
inline constexpr double kContactGap = kContactGapMax;

/// m: by this much the boxes of Bullet's box test are larger than the true ones on each side, so that it also sees
/// boxes that touch without overlap.
inline constexpr double kBoxPadding = 2.5e-4;

/// A shape and what Bullet needs to collide it.
struct CollisionShape {
  Shape shape;
  /// For the box test; boxes only.
  std::unique_ptr<btBoxShape> padded;

  explicit CollisionShape(const Shape& described);
};

/// The corner of a box that lies farthest in `direction`, in the world.
Vector3 FarthestCorner(const Box& box, const Placement& placement, const Vector3& direction);

/// The face, edge or corner with which a convex solid meets what lies in one direction: a polygon with its outward
/// normal, a segment, or a point. World coordinates.
struct SurfaceFeature {
  static constexpr int kVerticesMax = 4;
  std::array<Vector3, kVerticesMax> vertices;
  int count = 0;
  Vector3 normal = Vector3::Zero();  // of a polygon

  bool is_polygon() const { return count > 2; }
  void Add(const Vector3& vertex) { vertices[static_cast<size_t>(count++)] = vertex; }
};

/// Of a sphere, box, capsule or cylinder; the end of a cylinder is given as a square within its rim, of which one
/// corner lies farthest in `direction` (unit length).
SurfaceFeature SupportFeature(const Shape& shape, const Placement& placement, const Vector3& direction);

}  // namespace genphys::bullet_backend

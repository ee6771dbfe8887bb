#pragma once
#include <cstdint>
#include <vector>

#include "genphys/event.h"
#include "genphys/ids.h"
#include "genphys/math.h"

namespace genphys {

/// A segment from `origin` to `origin + translation`, world, m.
struct Ray {
  Vector3 origin = Vector3::Zero();
  Vector3 translation = Vector3::Zero();
};

/// The closest hit of a ray; ties go to the smaller entity id.
struct RayHit {
  EntityId entity;                   // null: no hit
  double fraction = 0;               // 0 to 1 along the translation
  Vector3 normal = Vector3::Zero();  // unit length, out of the surface, world
};

/// One geometry of an entity.
struct GeometryId {
  EntityId entity;
  uint32_t geometry = 0;  // unique in its entity
  auto operator<=>(const GeometryId&) const = default;
};

/// Where a ray enters a geometry first.
struct RayEntry {
  GeometryId hit;
  double fraction = 0;               // 0 to 1 along the translation
  Vector3 normal = Vector3::Zero();  // unit length, out of the surface, world
};

/// Where a shape that is moved along a straight line meets the first geometry; ties go to the smaller id.
struct ShapeCastHit {
  GeometryId hit;                      // null entity: none
  double fraction = 1;                 // 0 to 1 along the translation
  Vector3 position = Vector3::Zero();  // on the surface that was hit, m, world
  Vector3 normal = Vector3::Zero();    // unit length, out of that surface, world
};

/// The geometry nearest to a shape, or the distance of two entities.
struct ClosestPoints {
  GeometryId hit;                      // null entity: none
  double distance = 0;                 // m; negative: how deep they overlap
  Vector3 on_query = Vector3::Zero();  // closest point of the shape or of the first entity, m, world
  Vector3 on_hit = Vector3::Zero();    // closest point of what is near, or of the second entity, m, world
  Vector3 normal = Vector3::Zero();    // unit length, from the second of these points' body to the first's, world
};

/// What touches one entity, and where.
struct EntityContact {
  EntityId other;
  bool is_sensor = false;  // one of the two is a sensor
  std::vector<EventContactPoint> points;
};

}  // namespace genphys

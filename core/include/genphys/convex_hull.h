#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "genphys/math.h"
#include "genphys/shape.h"
#include "genphys/status.h"

namespace genphys {

/// A convex polyhedron, computed once and shared by all copies of a ConvexHull.
struct HullData {
  struct Face {
    Vector3 normal = Vector3::Zero();  // out of the body, unit length
    double offset = 0;                 // all corners have dot(normal, p) <= offset, m
    uint32_t first = 0;                // in face_corners
    uint32_t count = 0;
  };

  std::vector<Vector3> points;         // as asked for, m
  std::vector<Vector3> vertices;       // the corners of faces, in the order of `points`, m
  std::vector<Face> faces;             // of neighbouring coplanar triangles made one
  std::vector<uint32_t> face_corners;  // numbers of vertices, anticlockwise as seen from outside

  // What meets at vertex v: entries first[v] to first[v + 1].
  std::vector<uint32_t> neighbor_first;
  std::vector<uint32_t> neighbors;  // numbers of vertices at the other end of an edge
  std::vector<uint32_t> vertex_face_first;
  std::vector<uint32_t> vertex_faces;

  Vector3 low = Vector3::Zero();             // bounds, m
  Vector3 high = Vector3::Zero();            // m
  double thickness = 0;                      // least width over the directions of faces, m
  double volume = 0;                         // m^3
  Vector3 center_of_mass = Vector3::Zero();  // m
  Matrix3 tensor = Matrix3::Zero();          // about the centre of mass for unit density, m^5
  uint64_t hash = 0;                         // of `points`

  std::span<const uint32_t> CornersOf(const Face& face) const {
    return std::span(face_corners).subspan(face.first, face.count);
  }
};

/// The hull of `points` (m). Refuses, at "vertices": too few, not finite, outside the limits, or so flat that they
/// bound no body: thinner than 1e-5 of their extent or than twice the smallest size.
Result<ConvexHull> MakeConvexHull(std::vector<Vector3> points);

}  // namespace genphys

#pragma once
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "shapes/clipping.h"
#include "shapes/surface_triangles.h"

namespace genphys {

/// Tells of a triangle of a mesh or heightfield where what was cut at its edges has no end of its own. At the seam of
/// two triangles that lie in one plane nothing ends. At any other edge what lies on it does, and not what leans: that
/// comes nearer to this triangle or to the one beside, and there it meets it. Where a surface bends sharply or ends,
/// all does that overlaps it.
template <typename Surface>
class Seams {
 public:
  /// The corners of `triangle` are moved by minus `place`; `up` is its normal.
  Seams(const Surface& surface, const SurfaceTriangle& triangle, const Vector3& place, const Vector3& up)
      : surface_(surface), triangle_(triangle), place_(place), up_(up) {}

  /// `depth`: of the point at `corner`, m.
  bool IsSeam(const CutCorner& corner, const SolidFeature& incident, double depth) {
    bool is_level = true, is_even = true;
    const Fold* fold = nullptr;
    int edges = 0;
    for (size_t k = 0; k < 3; ++k) {
      if ((corner.edges >> k & 1) == 0) continue;
      fold = &FoldAt(k);
      is_level = is_level && std::abs(fold->slope) <= kLevel;
      is_even = is_even && std::abs(fold->slope) <= kEven;
      ++edges;
    }
    if (is_level) return true;
    if (!is_even && depth >= 0) return false;
    return edges == 1 ? !LiesOn(*fold, corner.outward) : !LiesOn(CornerAt(corner.edges), incident);
  }

 private:
  // Tangent of the angle up to which two triangles lie in one plane.
  static constexpr double kLevel = 1e-6;
  // Tangent of the angle up to which a surface counts as even.
  static constexpr double kEven = 0.2;
  // Tangent of the angle up to which what leans away from an edge still lies on it.
  static constexpr double kLeaning = 0.01;

  struct Fold {
    Vector3 outward;  // across the edge, in the plane of the triangle, unit length
    double slope;     // of the triangle beyond, minus infinity of none
  };

  // Of the edge from corner k: most corners that a triangle cuts are on two edges.
  const Fold& FoldAt(size_t k) {
    if (folds_[k]) return *folds_[k];
    const Vector3& corner = triangle_.corners[k];
    const Vector3 outward = (triangle_.corners[(k + 1) % 3] - corner).cross(up_).normalized();
    Fold& fold = folds_[k].emplace(Fold{outward, -std::numeric_limits<double>::infinity()});
    if (const std::optional<Vector3> across = Across(surface_, triangle_, k)) {
      const Vector3 beyond = *across - place_ - corner;
      const double reach = outward.dot(beyond);
      if (reach > 0) fold.slope = up_.dot(beyond) / reach;
    }
    return fold;
  }

  // Whether what goes on along `way`, over the edge, comes nearer to the surface on neither side of that. What
  // lies level and runs into a wall does, and still lies on the floor before it.
  bool LiesOn(const Fold& fold, const Vector3& way) const {
    const double rise = up_.dot(way), run = (way - rise * up_).norm();
    if (rise > kLeaning * run) return false;
    if (!std::isfinite(fold.slope)) return true;
    const double beyond = fold.slope > kEven ? 0 : fold.slope;
    return rise - beyond * fold.outward.dot(way) >= -kLeaning * run;
  }

  // Whether a face over a corner of the surface comes nearer to none of what lies round that.
  bool LiesOn(size_t k, const SolidFeature& face) const {
    const double facing = face.normal.dot(up_);
    if (!face.is_polygon() || !(facing < 0)) return false;
    bool lies_on = true;
    VisitNeighbors(surface_, triangle_.numbers[k], [&](const Vector3& neighbor) {
      const Vector3 edge = neighbor - place_ - triangle_.corners[k];
      // How much farther below the face the other end is.
      lies_on = lies_on && face.normal.dot(edge) / facing <= kLeaning * edge.norm();
    });
    return lies_on;
  }

  // Where two of the edges meet.
  static size_t CornerAt(uint32_t edges) { return (edges & 1) == 0 ? 2 : (edges & 2) != 0 ? 1 : 0; }

  const Surface& surface_;
  const SurfaceTriangle& triangle_;
  const Vector3& place_;
  const Vector3& up_;
  std::array<std::optional<Fold>, 3> folds_;
};

}  // namespace genphys

#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "absl/functional/function_ref.h"
#include "genphys/narrow_phase.h"
#include "shapes/solid.h"

namespace genphys {

/// A corner of what is left of a face or edge that was cut to within the edges of another face.
struct CutCorner {
  Vector3 position = Vector3::Zero();
  Vector3 outward = Vector3::Zero();  // where it was cut: how it went on beyond, of any length
  uint32_t edges = 0;                 // bit k: it was cut there by edge k of that face
};

/// Whether a corner at which `incident` was cut, a point of that depth (m), is no end of where the two meet.
using SeamTest = absl::FunctionRef<bool(const CutCorner& corner, const SolidFeature& incident, double depth)>;

/// Points on their way into a Manifold: too many, not yet sorted out.
class PointSet {
 public:
  /// Points with a larger gap (m) are left out.
  explicit PointSet(double gap) : gap_(gap) {}

  void Add(const MeetingPoint& point);
  /// A direction (of any length) that goes with one of the two that meet, along and across which a few points are
  /// looked for that span all of them: the same ones then from step to step.
  void SetAxis(const Vector3& axis) { axis_ = axis; }

  /// Appends to `manifold` at most four of the points: those that span the widest area, or nearly, and the deepest.
  void ReduceTo(Manifold& manifold) const;

  bool is_empty() const { return points_.empty(); }
  const absl::InlinedVector<MeetingPoint, 16>& points() const { return points_; }
  /// Depth of the deepest point; minus infinity if there is none.
  double deepest() const { return deepest_; }
  const Vector3& normal() const { return points_.front().normal; }

 private:
  double gap_;
  Vector3 axis_ = Vector3::Zero();  // none
  absl::InlinedVector<MeetingPoint, 16> points_;
  double deepest_ = -std::numeric_limits<double>::infinity();
};

/// Adds all points in which `a` and `b` meet, of which the direction `normal` (unit length, from a to b) is known:
/// faces and edges that lie flat on each other are cut to where both are. Adds nothing if only corners meet.
void AddFlatPoints(const Solid& a, const Solid& b, const Vector3& normal, PointSet& points);

/// The same, but where `b` was cut at a face of `a` and `is_seam` says so, the points go to `seams`.
void AddFlatPoints(const Solid& a, const Solid& b, const Vector3& normal, SeamTest is_seam, PointSet& points,
                   PointSet& seams);

/// The same for a polygon `a` that has `normal`, but `b` is cut to what lies straight below `a` or above it, along z.
void AddUprightPoints(const Solid& a, const Solid& b, const Vector3& normal, SeamTest is_seam, PointSet& points,
                      PointSet& seams);

}  // namespace genphys

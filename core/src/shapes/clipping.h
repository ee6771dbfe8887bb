#pragma once
#include <limits>
#include <vector>

#include "genphys/narrow_phase.h"
#include "shapes/solid.h"

namespace genphys {

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

}  // namespace genphys

#pragma once
#include "contacts.h"

namespace genphys::bullet_backend {

/// Points on their way into a Manifold: too many, not yet sorted out.
class PointSet {
 public:
  /// Two polygons of SurfaceFeature::kVerticesMax corners cut each other into at most twice as many; one is known
  /// before.
  static constexpr int kMax = 2 * SurfaceFeature::kVerticesMax + 1;

  /// Leaves out what has too large a gap.
  void Add(const MeetingPoint& point);

  /// Chooses the deepest point and those that span the widest area with it.
  void ReduceTo(Manifold& meeting) const;

  bool is_empty() const { return count_ == 0; }

 private:
  std::array<MeetingPoint, kMax> points_;
  int count_ = 0;
};

/// The points in which `incident` lies before or behind the polygon `reference`, within its sides. The normal of the
/// points is that of the polygon, turned round if `reference_is_b`.
void ClipToPolygon(const SurfaceFeature& reference, const SurfaceFeature& incident, bool reference_is_b,
                   PointSet& points);

}  // namespace genphys::bullet_backend

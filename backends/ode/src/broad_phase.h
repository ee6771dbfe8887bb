#pragma once
#include <cstdint>
#include <vector>

#include "aabb_tree.h"

namespace genphys::ode_backend {

/// Which geometries are near each other or a ray. Moving ones are kept apart from resting ones, so that a search for
/// pairs costs by the number of those that move.
class BroadPhase {
 public:
  /// A solid half-space dot(normal, p) <= offset, world. It counts as resting.
  struct HalfSpace {
    Vector3 normal = Vector3::UnitZ();
    double offset = 0;
  };

  void Add(GeometryRow row, const Aabb& box, bool moving);
  void AddHalfSpace(GeometryRow row, const HalfSpace& half_space);
  void Remove(GeometryRow row);

  /// Tells where the geometry is now.
  void Move(GeometryRow row, const Aabb& box);
  void MoveHalfSpace(GeometryRow row, const HalfSpace& half_space) {
    planes_[proxies_[Index(row)].index].half_space = half_space;
  }
  void SetMoving(GeometryRow row, bool moving);

  /// Calls visit(a, b), in no particular order, once for each pair that may touch and of which one or both move.
  template <typename Visit>
  void VisitPairs(Visit&& visit) const {
    for (GeometryRow row : moving_rows_) {
      const Aabb& box = proxies_[Index(row)].box;
      moving_.VisitOverlaps(box, [&](GeometryRow other) {
        // Each of two moving ones finds the other.
        if (Index(row) < Index(other) && proxies_[Index(other)].box.Overlaps(box)) visit(row, other);
      });
      resting_.VisitOverlaps(box, [&](GeometryRow other) {
        if (proxies_[Index(other)].box.Overlaps(box)) visit(row, other);
      });
      for (const Plane& plane : planes_) {
        if (Reaches(box, plane.half_space)) visit(row, plane.row);
      }
    }
  }

  /// Calls visit(row) for each geometry that the first `fraction` of `ray` may hit; `visit` may lower `fraction`.
  template <typename Visit>
  void VisitRay(const Ray& ray, const double& fraction, Visit&& visit) const {
    const BoxRay box_ray(ray);
    for (const Plane& plane : planes_) visit(plane.row);
    resting_.VisitRay(box_ray, fraction, visit);
    moving_.VisitRay(box_ray, fraction, visit);
  }

 private:
  enum class Kind : uint8_t { kAbsent, kResting, kMoving, kPlane };

  struct Proxy {
    Aabb box;  // tight
    AabbTree::Node leaf = AabbTree::kNone;
    uint32_t index = 0;  // in moving_rows_ or planes_
    Kind kind = Kind::kAbsent;
  };

  struct Plane {
    GeometryRow row{};
    HalfSpace half_space;
  };

  static bool Reaches(const Aabb& box, const HalfSpace& half_space);
  Proxy& NewProxy(GeometryRow row);
  void Enter(GeometryRow row, bool moving);
  void Leave(GeometryRow row);

  std::vector<Proxy> proxies_;  // by geometry row
  AabbTree moving_;
  AabbTree resting_;
  std::vector<GeometryRow> moving_rows_;
  std::vector<Plane> planes_;
};

}  // namespace genphys::ode_backend

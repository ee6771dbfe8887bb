#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "pairs/bounds_tree.h"

namespace genphys {

/// Which geometries are near each other or a ray. Moving ones are kept apart from resting ones, and whoever asks for
/// pairs remembers them: a search costs by the number of geometries that left the neighbourhood they were last seen in.
/// Where all that moves goes the same way, far from what rests, neighbourhoods go along.
class BroadPhase {
 public:
  /// A solid half-space dot(normal, p) <= offset, world. It counts as resting.
  struct HalfSpace {
    Vector3 normal = Vector3::UnitZ();
    double offset = 0;
  };

  /// Of geometries of the same `group`, unless it is BoundsTree::kNoGroup, none is a neighbour of another.
  void Add(GeometryRow row, const Bounds& box, bool moving, uint32_t group);
  void AddHalfSpace(GeometryRow row, const HalfSpace& half_space);
  void Remove(GeometryRow row);

  /// How a geometry came to where it is: where it was says where it goes next, unless it was put there. What is
  /// reserved for the time to come begins where its last place ended, and holds all of its way.
  enum class Course : uint8_t { kWent, kPut, kReserved };
  /// Tells where the geometry is now.
  void Move(GeometryRow row, const Bounds& box, Course course = Course::kWent);
  void MoveHalfSpace(GeometryRow row, const HalfSpace& half_space);
  void SetMoving(GeometryRow row, bool moving);
  /// Whoever moves no more from now on mostly does so for long.
  void PutAway() { resting_.TidyNewcomers(); }

  /// Neighbourhoods of moving geometries go `way` (m, world) until EndDrift(). What Move() is told until then is where
  /// a geometry may be as seen from what goes this way, at the beginning. No moving geometry may come near a resting
  /// one, nor until the next Settle(): such neighbours are not found.
  void BeginDrift(const Vector3& way);
  void EndDrift();
  void CancelDrift() { way_.setZero(); }
  /// Neighbourhoods stay where they are from now on, and what rests in them is found.
  void Settle();
  /// Whether nothing that rests is in `box`.
  bool IsFreeOfResting(const Bounds& box) const;

  /// Geometries that came, went, changed sides or left their neighbourhood since the last ForgetFresh().
  bool IsFresh(GeometryRow row) const { return proxies_[Index(row)].is_fresh; }
  bool any_fresh() const { return !fresh_rows_.empty(); }
  void MarkFresh(GeometryRow row);
  void ForgetFresh();

  /// Calls visit(a, b), in no particular order, once for each pair of neighbours of which one or both are fresh. It
  /// returns whether the two matter to each other: who has none that does will have a neighbourhood that reaches
  /// farther ahead.
  template <typename Visit>
  void VisitFreshPairs(Visit&& visit) {
    moving_.Tidy();
    resting_.Tidy();
    const auto meet = [&](GeometryRow a, GeometryRow b) {
      if (visit(a, b)) proxies_[Index(a)].has_met = proxies_[Index(b)].has_met = true;
    };
    // Where most are fresh, it takes less to go through all pairs once than to look around each.
    const bool are_most_fresh = kMost * fresh_rows_.size() > moving_rows_.size();
    if (are_most_fresh) {
      moving_.VisitPairs([&](GeometryRow a, GeometryRow b) {
        if (IsFresh(a) || IsFresh(b)) meet(a, b);
      });
    }
    for (const GeometryRow row : fresh_rows_) {
      VisitNeighbours(row, !are_most_fresh, [&](GeometryRow other) {
        // Each of two fresh ones finds the other.
        if (other != row && (!IsFresh(other) || Index(row) < Index(other))) meet(row, other);
      });
    }
  }

  /// Of a box that rests.
  const Bounds& NeighbourhoodOf(GeometryRow row) const { return proxies_[Index(row)].neighbourhood; }

  /// Whether two neighbours may touch.
  bool MayTouch(GeometryRow a, GeometryRow b) const;

  /// Whether the bounds of the geometry, or the region reserved for it, overlap `box`.
  bool MayTouch(GeometryRow row, const Bounds& box) const;

  /// Whether `box` lies in the neighbourhood of a moving geometry, and no geometry is fresh.
  bool Surrounds(GeometryRow row, const Bounds& box) const;
  /// Whether the neighbourhood of the geometry overlaps `box`.
  bool MayReach(GeometryRow row, const Bounds& box) const;

  /// Calls visit(row) for each geometry that the first `fraction` of `ray` may hit; `visit` may lower `fraction`.
  template <typename Visit>
  void VisitRay(const Ray& ray, const double& fraction, Visit&& visit) const {
    const BoxRay box_ray(ray);
    for (const Plane& plane : planes_) visit(plane.row);
    resting_.VisitRay(box_ray, fraction, visit);
    moving_.VisitRay(BoxRay({ray.origin - drift_, ray.translation}), fraction, visit);
  }

  /// Calls visit(row) for each geometry that may be no farther from `box` than `within` (m), which `visit` may lower
  /// meanwhile, and for all planes; the nearer ones mostly come first.
  template <typename Visit>
  void VisitNearest(const Bounds& box, const double& within, Visit&& visit) const {
    for (const Plane& plane : planes_) visit(plane.row);
    resting_.VisitNearest(box, within, visit);
    moving_.VisitNearest(box.Shifted(-drift_), within, visit);
  }

  /// Calls visit(row) for each geometry whose neighbourhood overlaps `box`, and for all planes, but for boxes of the
  /// group `left_out`.
  template <typename Visit>
  void VisitBounds(const Bounds& box, uint32_t left_out, Visit&& visit) const {
    for (const Plane& plane : planes_) visit(plane.row);
    resting_.VisitOverlaps(box, left_out, visit);
    moving_.VisitOverlaps(box.Shifted(-drift_), left_out, visit);
  }

 private:
  enum class Kind : uint8_t { kAbsent, kResting, kMoving, kPlane };

  // How far a neighbourhood reaches along the last displacement: to find it a new place in the tree is dear, and so are
  // neighbours who are none.
  static constexpr uint8_t kAhead = 8, kAheadMost = 64;
  // Of its own size: who goes farther in a step passes others while its neighbourhood holds many that it never meets.
  static constexpr double kFar = 0.5;

  // More than one in so many: to look around one takes as long as to go past so many, and past eight of 100,000.
  static constexpr size_t kMost = 4;

  struct Proxy {
    Bounds box;            // tight; of a moving one as seen from what drifts
    Bounds neighbourhood;  // the same of its leaf, which lies elsewhere in memory and is asked for at every move
    BoundsTree::Node leaf = BoundsTree::kNone;
    uint32_t index = 0;  // in moving_rows_ or planes_
    uint32_t group = BoundsTree::kNoGroup;
    Kind kind = Kind::kAbsent;
    bool is_fresh = false;
    bool has_met = false;  // since it has this neighbourhood
    uint8_t ahead = 1;     // displacements
  };

  struct Plane {
    GeometryRow row{};
    HalfSpace half_space;
  };

  // Calls visit(row) for all neighbours of `row`, if it moves for those that move only on request, and maybe for
  // itself.
  template <typename Visit>
  void VisitNeighbours(GeometryRow row, bool among_moving, Visit&& visit) const {
    const Proxy& proxy = proxies_[Index(row)];
    if (proxy.kind == Kind::kAbsent) return;
    if (proxy.kind == Kind::kPlane) {
      for (GeometryRow other : moving_rows_) {
        if (Reaches(NeighbourhoodOf(proxies_[Index(other)]), planes_[proxy.index].half_space)) visit(other);
      }
      return;
    }
    if (proxy.kind == Kind::kResting) {
      const Bounds seen = proxy.neighbourhood.Shifted(-drift_);
      moving_.VisitOverlaps(seen.Union(seen.Shifted(-way_)), proxy.group, visit);
      return;
    }
    if (among_moving) moving_.VisitOverlaps(proxy.neighbourhood, proxy.group, visit);
    const Bounds box = NeighbourhoodOf(proxy);
    resting_.VisitOverlaps(box, proxy.group, visit);
    for (const Plane& plane : planes_) {
      if (Reaches(box, plane.half_space)) visit(plane.row);
    }
  }

  // In the world, until the drift ends.
  Bounds InWorld(const Proxy& proxy, const Bounds& box) const {
    if (proxy.kind != Kind::kMoving || !has_drifted_) return box;
    const Bounds now = box.Shifted(drift_);
    return now.Union(now.Shifted(way_));
  }
  Bounds BoxOf(const Proxy& proxy) const { return InWorld(proxy, proxy.box); }
  Bounds NeighbourhoodOf(const Proxy& proxy) const { return InWorld(proxy, proxy.neighbourhood); }

  static bool Reaches(const Bounds& box, const HalfSpace& half_space);
  static uint8_t NextAhead(const Proxy& proxy, bool goes_far);
  static void Enter(BoundsTree& tree, const Bounds& neighbourhood, GeometryRow row, Proxy& proxy);
  Proxy& NewProxy(GeometryRow row);
  void Enter(GeometryRow row, bool moving);
  void Leave(GeometryRow row);
  void Narrow(GeometryRow row, Proxy& proxy);

  std::vector<Proxy> proxies_;  // by geometry row
  BoundsTree moving_;           // as seen from what drifts
  BoundsTree resting_;
  std::vector<GeometryRow> moving_rows_;
  std::vector<Plane> planes_;
  std::vector<GeometryRow> fresh_rows_;
  Vector3 drift_ = Vector3::Zero();  // m, how far it has drifted since it settled
  Vector3 way_ = Vector3::Zero();    // m, how far it drifts until EndDrift()
  bool has_drifted_ = false;         // since it settled
};

}  // namespace genphys

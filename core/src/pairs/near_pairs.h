#pragma once
#include <span>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "genphys/backend.h"
#include "genphys/contact.h"
#include "genphys/pair_rule.h"
#include "genphys/row_marks.h"
#include "pairs/broad_phase.h"

namespace genphys {

/// More than what is allowed are near each other or touch.
class BudgetExceeded : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Where all geometries of a world are, and which of them are near enough to each other to be asked for contact points.
/// What it finds depends on where they are and who moves, and not on how that came about.
class NearPairs {
 public:
  /// From now on whatever finds more than that throws BudgetExceeded, and has to look for all of it again.
  void set_budget(const ContactBudget& budget) { budget_ = budget; }
  /// Throws BudgetExceeded if there are more than that already.
  void Check(const ContactBudget& budget, const ContactBuffer& contacts) const;

  /// One entity's geometries, in the order of its description.
  struct Member {
    const RigidBody& body;
    std::span<const GeometryRow> geometries;
  };

  /// Its geometries are known to `rule`.
  void Add(const PairRule& rule, const Member& member, const Pose& pose, bool is_active);
  void Remove(std::span<const GeometryRow> geometries);
  void SetActive(const Member& member, bool is_active);

  /// Those that a step put to sleep are all inactive by now, and mostly stay so for long.
  void PutAway() { broad_phase_.PutAway(); }

  /// Puts the geometries to where their entity is now.
  void Place(const Member& member, const Pose& pose);

  /// Says that the geometries of one entity stay within `region` until they are placed again: until then they are taken
  /// to be all over it. The first region after they were placed is another kind of place, and no way that they went.
  void Reserve(std::span<const GeometryRow> geometries, const Bounds& region, bool is_first);

  /// Says that all that moves goes `way` (m, world) in the time to come, and what Reserve() is told until EndDrift() is
  /// where that may be as seen from what goes this way. Nothing that moves may come near what rests, until Settle().
  void BeginDrift(const Vector3& way) { broad_phase_.BeginDrift(way); }
  void EndDrift() { broad_phase_.EndDrift(); }
  void CancelDrift() { broad_phase_.CancelDrift(); }
  void Settle() { broad_phase_.Settle(); }
  /// Of a geometry that rests, no plane: whatever overlaps these is near it.
  const Bounds& BoundsOf(GeometryRow row) const { return broad_phase_.NeighbourhoodOf(row); }
  /// Whether nothing that rests is near `bounds`.
  bool IsFreeOfResting(const Bounds& bounds) const { return broad_phase_.IsFreeOfResting(bounds); }

  /// Asks the rule again about all pairs with these, for it has changed.
  void Renew(std::span<const GeometryRow> geometries);

  /// Two geometries near each other that the rule does not ignore; one at least moves.
  struct Pair {
    EntityId id_a;  // the smaller
    EntityId id_b;
    uint32_t geometry_id_a = 0;
    uint32_t geometry_id_b = 0;
    EntityRow entity_a{};
    EntityRow entity_b{};
    GeometryRow a{};
    GeometryRow b{};
    bool is_sensor = false;

    /// Canonical.
    bool operator<(const Pair& o) const {
      return std::tie(id_a, id_b, geometry_id_a, geometry_id_b) <
             std::tie(o.id_a, o.id_b, o.geometry_id_a, o.geometry_id_b);
    }
  };

  /// All such pairs in canonical order, and some that are not quite near. Good until the next call.
  std::span<const Pair> Update(const PairRule& rule);

  /// The same as of the last Update().
  std::span<const Pair> pairs() const { return pairs_; }

  /// Whether all who may overlap `bounds` and whom the rule does not ignore are among the pairs() of `own`, now.
  bool KnowsAllIn(GeometryRow own, const Bounds& bounds) const { return broad_phase_.Surrounds(own, bounds); }

  /// Whether what is near `row` may overlap `bounds`.
  bool MayReach(GeometryRow row, const Bounds& bounds) const { return broad_phase_.MayReach(row, bounds); }

  /// Whether the bounds of the two overlap.
  bool MayTouch(const Pair& pair) const { return broad_phase_.MayTouch(pair.a, pair.b); }
  /// Whether those of a geometry, or the region reserved for it, overlap `bounds`.
  bool MayTouch(GeometryRow row, const Bounds& bounds) const { return broad_phase_.MayTouch(row, bounds); }

  /// Overwrites `contacts` with all points of near pairs, as the engine finds them, in canonical order.
  void Collide(const PairRule& rule, BackendWorld& engine, ContactBuffer& contacts);

  /// The same after some rows moved: what has none of them is left as it is. The pairs are in canonical order; their
  /// points may lie anywhere until PutInOrder().
  void CollideMoved(const PairRule& rule, BackendWorld& engine, const RowMarks& moved, ContactBuffer& contacts);
  void PutInOrder(ContactBuffer& contacts);

  /// Calls visit(row) for each geometry that the first `fraction` of `ray` may hit; `visit` may lower `fraction`.
  template <typename Visit>
  void VisitRay(const Ray& ray, const double& fraction, Visit&& visit) const {
    broad_phase_.VisitRay(ray, fraction, visit);
  }

  /// Calls visit(row) for each geometry that may be no farther from `bounds` than `within` (m), which `visit` may lower
  /// meanwhile, and for all planes; the nearer ones mostly come first.
  template <typename Visit>
  void VisitNearest(const Bounds& bounds, const double& within, Visit&& visit) const {
    broad_phase_.VisitNearest(bounds, within, visit);
  }

  /// Calls visit(row) for each geometry that may overlap `bounds`, and for all planes.
  template <typename Visit>
  void VisitBounds(const Bounds& bounds, Visit&& visit) const {
    broad_phase_.VisitBounds(bounds, BoundsTree::kNoGroup, visit);
  }

  /// The same for `own`, without most of those that it ignores since they are in its collision space.
  template <typename Visit>
  void VisitOthers(const PairRule& rule, GeometryRow own, const Bounds& bounds, Visit&& visit) const {
    broad_phase_.VisitBounds(bounds, rule.info(own).space, visit);
  }

 private:
  // Whether the two are a pair.
  bool AddPair(const PairRule& rule, GeometryRow a, GeometryRow b);
  static void CheckPairs(size_t pairs, size_t most);
  static void CheckPoints(size_t points, size_t most);
  // A pair without points, which belong behind all others.
  static ContactPair Opened(const PairRule& rule, const Pair& pair, const ContactBuffer& contacts);
  void Overwrite(const std::vector<ContactPoint>& points, ContactPair& pair, ContactBuffer& contacts);
  void Insert(const PairRule& rule, ContactBuffer& contacts);

  BroadPhase broad_phase_;
  ContactBudget budget_;
  std::vector<Pair> pairs_;    // as of the last Update()
  bool is_scattered_ = false;  // points are not in the order of their pairs
  // Kept between calls for their memory only.
  std::vector<Pair> found_;
  std::vector<Pair> merged_;
  std::vector<ContactPair> come_;
  std::vector<ContactPoint> points_;
};

}  // namespace genphys

#include "shapes/surface_contacts.h"

#include <algorithm>
#include <cmath>

#include "genphys/bounds.h"
#include "genphys/work_watch.h"
#include "shapes/seams.h"
#include "shapes/separation.h"

namespace genphys {
namespace {

// Sine of the angle by which a neighbouring vertex may stand out of the plane in which a corner or edge is touched.
constexpr double kLevel = 1e-6;
// Cosine between two normals above which they push in one direction.
constexpr double kSameNormal = 1 - 1e-6;
// By a little less than this two directions with that cosine differ.
constexpr double kSameDirection = 1.5e-3;
// Up to so many groups are looked at one after another.
constexpr size_t kFewGroups = 32;
// Of the size of the solid: nearer points are one.
constexpr double kSamePoint = 1e-6;
// Cosine between two normals below which they are those of two sides, not of one that goes on evenly.
constexpr double kAlike = 0.92;
// No more groups than these of the deepest points at seams are looked at: a manifold holds no more.
constexpr size_t kSeamGroupsMax = Manifold::kPointsMax;
// A group with so many points is thinned out before more come.
constexpr size_t kGroupMax = 64;
// What overlaps a triangle by more than this part of its own size along its normal, and by less than a fraction of that
// in another direction, meets one of the triangles beside it.
constexpr double kDeep = 0.5;
constexpr double kMuchLess = 0.25;
// Of the size of the solid: what is no deeper in the ground than this may only touch it, for ways out of what is round
// are searched for.
constexpr double kSunk = 1e-2;

// A solid, moved so that its place is the origin.
struct Incident {
  Incident(const Shape& shape, const Placement& placement)
      : solid(shape, {Vector3::Zero(), placement.rotation}),
        place(placement.position),
        axes(placement.rotation),
        bounds(BoundsOf(shape, {})) {}

  Solid solid;
  Vector3 place;
  Matrix3 axes;
  Bounds bounds;  // along these
};

// One surface and one solid, both moved so that the solid's place is the origin.
template <typename Surface>
class Meeting {
 public:
  Meeting(const Surface& surface, bool is_solid_below, const Incident& incident, double gap, SurfacePoints& points,
          SurfacePoints& seams)
      : surface_(surface),
        is_solid_below_(is_solid_below),
        incident_(incident),
        solid_(incident.solid),
        place_(incident.place),
        gap_(gap),
        points_(points),
        seams_(seams) {}

  void Meet(SurfaceTriangle triangle) {
    WorkWatch::Look(kTriangleWork);
    for (Vector3& corner : triangle.corners) corner -= place_;
    const Vector3 up = triangle.AreaVector().normalized();
    const double level = up.dot(triangle.corners[0]);
    if (-solid_.Reach(-up) - level > gap_) return;
    const bool is_behind = solid_.Reach(up) < level;
    const Solid flat(triangle);
    if (is_behind) return AddBelow(triangle, flat, up);
    if (IsAside(triangle)) return;
    if (PushesUpwardsOnly(triangle, up, level)) return Add(triangle, flat, up, up, std::nullopt);
    if (const auto apart = Apart(flat)) {
      MeetApart(triangle, flat, up, *apart);
    } else {
      MeetOverlapping(triangle, flat, up);
    }
  }

  // What is in the ground is pushed out of it, even if no corner of it lies where its triangles look for one.
  void AddLast() {
    if (last_.depth < kSunk * solid_.size() || points_.HasOverlap() || seams_.HasOverlap()) return;
    PointSet last(0);
    last.Add(last_);
    points_.Add(last);
  }

 private:
  void MeetApart(const SurfaceTriangle& triangle, const Solid& flat, const Vector3& up, const Separation& apart) {
    if (apart.normal.dot(up) < 0) return AddBelow(triangle, flat, up);
    if (apart.depth < -gap_) return;
    if (Pushes(triangle, up, apart.normal)) {
      Add(triangle, flat, up, apart.normal, apart);
    } else {
      Add(triangle, flat, up, up, std::nullopt);
    }
  }

  // Whether the bounds of the solid as it is turned show that it is farther away than matters, and not straight below.
  bool IsAside(const SurfaceTriangle& triangle) const {
    const auto& [a, b, c] = triangle.corners;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 direction = incident_.axes.col(axis);
      const auto [low, high] = std::minmax({direction.dot(a), direction.dot(b), direction.dot(c)});
      const bool is_before = incident_.bounds.min[axis] - high > gap_,
                 is_after = low - incident_.bounds.max[axis] > gap_;
      if (!is_before && !is_after) continue;
      if (!is_solid_below_ || (is_before ? direction.z() : -direction.z()) >= 0) return true;
    }
    return false;
  }

  // Of what is farther apart than matters only that is told, unless it is straight below.
  std::optional<Separation> Apart(const Solid& flat) const {
    const std::optional<Separation> apart = SeparationApart(flat, solid_, gap_);
    const bool may_be_below = is_solid_below_ && apart && apart->depth < -gap_ && apart->normal.z() < 0;
    return may_be_below ? SeparationApart(flat, solid_) : apart;
  }

  // Whether a point is over the triangle as seen along its normal.
  static bool IsOver(const SurfaceTriangle& triangle, const Vector3& up, const Vector3& point) {
    for (size_t i = 0; i < 3; ++i) {
      const Vector3& corner = triangle.corners[i];
      if (!(up.dot((triangle.corners[(i + 1) % 3] - corner).cross(point - corner)) > 0)) return false;
    }
    return true;
  }

  // Of what is deepest over the triangle no small turn from its normal makes less.
  Separation SeparationUpwards(const Vector3& up, double depth, const Vector3& deepest) const {
    return {up, depth, deepest + (depth / 2 - solid_.radius()) * up};
  }

  void MeetOverlapping(const SurfaceTriangle& triangle, const Solid& flat, const Vector3& up) {
    const double upward = OverlapAlong(flat, solid_, up);
    double least = upward, least_pushing = upward;
    std::optional<Separation> best;
    const auto consider = [&](const Separation& found) {
      least = std::min(least, found.depth);
      if (found.depth >= least_pushing || !Pushes(triangle, up, found.normal)) return;
      least_pushing = found.depth;
      best = found;
    };
    const Vector3 deepest = solid_.Support(-up);
    consider(IsOver(triangle, up, deepest) ? SeparationUpwards(up, upward, deepest) : Descend(flat, solid_, up));
    if (const auto shallow = ShallowSeparation(flat, solid_)) consider(*shallow);
    // What is deep, and would be out much sooner another way, over a ridge, is met there; in a heightfield if it would
    // be out sooner at all.
    const bool is_deep = least_pushing > kDeep * solid_.size();
    const auto is_met_beside = [&] {
      return is_solid_below_ ? DepthBelow(triangle) < least_pushing * (1 - kSamePoint)
                             : least < kMuchLess * least_pushing;
    };
    if (best && !(is_deep && is_met_beside())) return Add(triangle, flat, up, best->normal, best);
    ConsiderLast(up, least);
    if (upward > kDeep * solid_.size()) {
      if (is_solid_below_) return AddBelow(triangle, flat, up);
      if (least < kMuchLess * upward) return;
    }
    Add(triangle, flat, up, up, std::nullopt);
  }

  // Whether the surface has a place on this triangle where it can push along `normal`: nothing that joins the corner or
  // edge that reaches farthest that way stands out of the plane across it. Beyond the ends of an edge something may, as
  // at a saddle: that is nearer there, and pushes by itself. Of the whole triangle nothing round it does.
  bool Pushes(const SurfaceTriangle& triangle, const Vector3& up, const Vector3& normal) const {
    if (normal.dot(up) < -kLevel) return false;
    const auto height = [&](size_t i) { return normal.dot(triangle.corners[i]); };
    const double highest = std::max({height(0), height(1), height(2)});
    const double slack = kLevel * Solid(triangle).size();
    const auto is_highest = [&](size_t i) { return height(i % 3) >= highest - slack; };
    bool pushes = true;
    for (size_t i = 0; i < 3 && pushes; ++i) {
      if (!is_highest(i)) continue;
      const auto look_at = [&](const Vector3& vertex) {
        const Vector3 edge = vertex - place_ - triangle.corners[i];
        pushes &= normal.dot(edge) <= kLevel * edge.norm();
      };
      if (is_highest(i + 1) == is_highest(i + 2)) {
        VisitNeighbors(surface_, triangle.numbers[i], look_at);
      } else if (is_highest(i + 1)) {
        VisitAcross(surface_, triangle, i, look_at);
      }
    }
    return pushes;
  }

  // Of a triangle that all around lies flat or in a hollow there is nothing to search. What overlaps it deeply is
  // looked at more closely, for it may rather meet a triangle beside it.
  bool PushesUpwardsOnly(const SurfaceTriangle& triangle, const Vector3& up, double level) const {
    if (level + solid_.Reach(-up) > kDeep * solid_.size()) return false;
    bool is_lowest = true;
    for (size_t i = 0; i < 3 && is_lowest; ++i) {
      is_lowest = !IsAtRim(surface_, triangle.numbers[i]);
      VisitNeighbors(surface_, triangle.numbers[i], [&](const Vector3& neighbor) {
        const Vector3 edge = neighbor - place_ - triangle.corners[i];
        is_lowest &= up.dot(edge) >= -kLevel * edge.norm();
      });
    }
    return is_lowest;
  }

  // `closest`: where they meet if no faces do.
  void Add(const SurfaceTriangle& triangle, const Solid& flat, const Vector3& up, const Vector3& normal,
           const std::optional<Separation>& closest) {
    PointSet points(gap_), seams(gap_);
    Seams round(surface_, triangle, place_, up);
    AddFlatPoints(flat, solid_, normal, TestOf(round), points, seams);
    // What is not over this triangle, along its normal, is over the one beside it. Over a bend, however slight, it is
    // over neither.
    const bool is_flat = !closest || up.cross(normal).squaredNorm() <= kLevel * kLevel;
    if (points.is_empty() && seams.is_empty() && !is_flat) {
      points.Add({.position = closest->place, .normal = closest->normal, .depth = closest->depth});
    }
    Take(points, seams);
  }

  // What lies behind the triangle is below the surface where that is straight above it. Beside that, what is behind one
  // side of a ridge may be in the air over the other side.
  void AddBelow(const SurfaceTriangle& triangle, const Solid& flat, const Vector3& up) {
    if (!is_solid_below_) return;
    // It is the core of what is round that was cut, and lies below.
    PointSet points(-solid_.radius()), seams(-solid_.radius());
    Seams round(surface_, triangle, place_, up);
    AddUprightPoints(flat, solid_, up, TestOf(round), points, seams);
    Take(points, seams);
    if (points_.HasOverlap() || seams_.HasOverlap()) return;
    // No corner of it is there, but an edge or a side may be.
    ConsiderLast(up, DepthBelow(triangle));
  }

  // How deep it is in what lies straight below the triangle.
  double DepthBelow(const SurfaceTriangle& triangle) const {
    // The bottom of the column is no way out.
    const auto& [a, b, c] = triangle.corners;
    const double drop = std::max({a.z(), b.z(), c.z()}) + solid_.Reach(-Vector3::UnitZ());
    const Solid column(triangle, 2 * drop);
    // Either may end at a way out that is not the least.
    return std::min(Descend(column, solid_, Vector3::UnitZ()).depth, FindSeparation(column, solid_).depth);
  }

  static auto TestOf(Seams<Surface>& round) {
    return [&round](const CutCorner& corner, const SolidFeature& incident, double depth) {
      return round.IsSeam(corner, incident, depth);
    };
  }

  void Take(const PointSet& points, const PointSet& seams) {
    points_.Add(points);
    // On an even surface that is none, as soon as the deepest point is known.
    PointSet lacking(gap_);
    for (const MeetingPoint& point : seams.points()) {
      if (!points_.HasAsDeep(point)) lacking.Add(point);
    }
    seams_.Add(lacking);
  }

  // Of a triangle that the solid overlaps, or that lies straight above a part of it.
  void ConsiderLast(const Vector3& up, double depth) {
    if (depth <= last_.depth) return;
    last_ = {SeparationUpwards(up, depth, solid_.Support(-up)).place, up, depth};
  }

  const Surface& surface_;
  bool is_solid_below_;
  const Incident& incident_;
  const Solid& solid_;
  const Vector3& place_;
  double gap_;
  SurfacePoints& points_;
  SurfacePoints& seams_;
  MeetingPoint last_;  // the deepest of those that are taken if there are no others
};

}  // namespace

SurfacePoints::SurfacePoints(double gap, const Solid& solid)
    : gap_(gap), solid_(solid), same_(kSamePoint * solid.size()) {}

// The first one that fits.
size_t SurfacePoints::GroupFor(const Vector3& normal) {
  const auto fits = [&](const PointSet& group) { return group.normal().dot(normal) > kSameNormal; };
  size_t first = groups_.size();
  if (groups_.size() <= kFewGroups) {
    first = static_cast<size_t>(std::ranges::find_if(groups_, fits) - groups_.begin());
  } else {
    group_at_.VisitNear(normal, kSameDirection, [&](uint32_t number) {
      if (number < first && fits(groups_[number])) first = number;
    });
  }
  if (first < groups_.size()) return first;
  groups_.emplace_back(gap_);
  if (groups_.size() == kFewGroups + 1) {
    for (uint32_t i = 0; i < kFewGroups; ++i) group_at_.Add(groups_[i].normal(), i);
  }
  if (groups_.size() > kFewGroups) group_at_.Add(normal, static_cast<uint32_t>(first));
  return first;
}

void SurfacePoints::Add(const PointSet& points) {
  for (const MeetingPoint& point : points.points()) {
    const size_t number = GroupFor(point.normal);
    PointSet& group = groups_[number];
    const auto is_same = [&](const MeetingPoint& other) {
      return (other.position - point.position).squaredNorm() < same_ * same_;
    };
    if (std::any_of(group.points().begin(), group.points().end(), is_same)) continue;
    if (group.points().size() >= kGroupMax) {
      Manifold thinned;
      InOrder(group).ReduceTo(thinned);
      group = PointSet(gap_);
      for (int i = 0; i < thinned.count; ++i) group.Add(thinned.points[static_cast<size_t>(i)]);
      if (groups_.size() > kFewGroups) group_at_.Add(group.normal(), static_cast<uint32_t>(number));
    }
    group.Add(point);
  }
}

// Few are chosen from many, and of equals the first: those as the corners of the solid come, as where it meets one
// face, not as the triangles do.
PointSet SurfacePoints::InOrder(const PointSet& group) const {
  const Vector3& normal = group.normal();
  absl::InlinedVector<const MeetingPoint*, 16> left;
  for (const MeetingPoint& point : group.points()) left.push_back(&point);
  PointSet ordered(gap_);
  for (const Vector3& corner : solid_.FeatureAt(-normal).corners) {
    WorkWatch::Look(static_cast<int64_t>(left.size()));
    const auto found = std::ranges::find_if(left, [&](const MeetingPoint* point) {
      return (point->position - corner).cross(normal).squaredNorm() < same_ * same_;
    });
    if (found == left.end()) continue;
    ordered.Add(**found);
    left.erase(found);
  }
  for (const MeetingPoint* point : left) ordered.Add(*point);
  return ordered;
}

// By their depth. What is sorted takes no more points.
void SurfacePoints::SortGroups() {
  std::stable_sort(groups_.begin(), groups_.end(),
                   [](const PointSet& a, const PointSet& b) { return a.deepest() > b.deepest(); });
}

bool SurfacePoints::HasOverlap() const {
  return std::ranges::any_of(groups_, [](const PointSet& group) { return group.deepest() >= 0; });
}

bool SurfacePoints::HasAsDeep(const MeetingPoint& point) const {
  return std::ranges::any_of(
      std::span(groups_).first(std::min(groups_.size(), kFewGroups)), [&](const PointSet& group) {
        return group.deepest() >= point.depth - same_ && group.normal().dot(point.normal) > kAlike;
      });
}

void SurfacePoints::AddLacking(SurfacePoints& seams) {
  if (seams.groups_.empty()) return;
  seams.SortGroups();
  const auto own = static_cast<std::ptrdiff_t>(groups_.size());
  for (const PointSet& group : std::span(seams.groups_).first(std::min(seams.groups_.size(), kSeamGroupsMax))) {
    const auto is_met_beside = [&](const PointSet& other) {
      return other.deepest() >= group.deepest() - same_ && other.normal().dot(group.normal()) > kAlike;
    };
    if (std::any_of(groups_.begin(), groups_.begin() + own, is_met_beside)) continue;
    Add(group);
  }
}

void SurfacePoints::ReduceTo(Manifold& manifold) {
  SortGroups();
  for (const PointSet& group : groups_) {
    if (manifold.count + Manifold::kPointsPerNormal > Manifold::kPointsMax) return;
    InOrder(group).ReduceTo(manifold);
  }
}

void FindSurfaceContacts(const Shape& surface, const Shape& shape, const Placement& placement, double gap,
                         Manifold& manifold) {
  const Incident incident(shape, placement);
  const Bounds bounds = BoundsOf(shape, placement).Widened(gap);
  SurfacePoints points(gap, incident.solid), seams(gap, incident.solid);
  if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) {
    Meeting meeting(*mesh->data, false, incident, gap, points, seams);
    VisitTriangles(
        *mesh->data, [&](const Bounds& box) { return box.Overlaps(bounds); },
        [&](const SurfaceTriangle& triangle) { meeting.Meet(triangle); });
  } else if (const auto* field = std::get_if<Heightfield>(&surface)) {
    Meeting meeting(*field->data, true, incident, gap, points, seams);
    // All that lies below is solid, however deep.
    const auto is_over = [&](Bounds box) {
      box.min.z() = std::min(box.min.z(), bounds.min.z());
      return box.Overlaps(bounds);
    };
    VisitTriangles(*field->data, is_over, [&](const SurfaceTriangle& triangle) { meeting.Meet(triangle); });
    meeting.AddLast();
  }
  const int first = manifold.count;
  points.AddLacking(seams);
  points.ReduceTo(manifold);
  for (int i = first; i < manifold.count; ++i) manifold.points[static_cast<size_t>(i)].position += placement.position;
}

}  // namespace genphys

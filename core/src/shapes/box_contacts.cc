#include "shapes/box_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "genphys/narrow_phase.h"

namespace genphys {
namespace {

// Of the way to where points are no longer told: by so much sooner has a direction to part the boxes than one that
// comes before it. Edges of boxes that lie flat on each other have theirs as near as this.
constexpr double kSooner = 0.05;
// Squared sine between two edges below which they have no direction across both.
constexpr double kAlong = 1e-6;
// Within this of one is the cosine between a direction across two edges and the normal of a face that is as good.
constexpr double kFlat = 1e-4;
// Of the size of a face: by so much it is taken to be wider, lest a point on the seam of two be on neither.
constexpr double kSeam = 1e-9;

// m, and of their smallest half extent if that is less: what overlaps by no more than that is flush.
constexpr double kFlush = 1e-4, kFlushPart = 1e-2;
// The cosine of the angle between directions that are as good as perpendicular.
constexpr double kAcross = 0.1;

constexpr int kNone = -1;

int Next(int axis) { return axis == 2 ? 0 : axis + 1; }

// Two boxes in the frame of the first.
struct BoxPair {
  const Vector3& half_a;
  const Vector3& half_b;
  Matrix3 turn;    // the axes of b
  Matrix3 slant;   // |turn|
  Vector3 offset;  // of the centre of b
};

// A direction, and how far apart the boxes are along it, m; negative where they overlap. Of a face of one box only its
// axis is set, of edges both.
struct Direction {
  double separation = -std::numeric_limits<double>::infinity();
  int axis_a = kNone;
  int axis_b = kNone;

  bool is_edges() const { return axis_a != kNone && axis_b != kNone; }
};

// How far along a direction that parts them by `separation` boxes may be from what is true, m.
double Tolerance(double separation, double gap) { return kSooner * (gap - separation); }

void TakeSooner(const Direction& direction, Direction& best) {
  if (direction.separation > best.separation) best = direction;
}

// The first is taken unless the second is better by more than the tolerance.
const Direction& Preferred(const Direction& first, const Direction& second, double gap) {
  return second.separation > first.separation + Tolerance(first.separation, gap) ? second : first;
}

Direction FaceOfA(const BoxPair& pair, int axis) {
  return {std::abs(pair.offset[axis]) - pair.half_a[axis] - pair.slant.row(axis).dot(pair.half_b), axis, kNone};
}

Direction FaceOfB(const BoxPair& pair, int axis) {
  const double between = std::abs(pair.turn.col(axis).dot(pair.offset));
  return {between - pair.half_b[axis] - pair.slant.col(axis).dot(pair.half_a), kNone, axis};
}

// Across edges that lie along `axis_a` and `axis_b`, whose squared sine is given.
Direction AcrossEdges(const BoxPair& pair, int axis_a, int axis_b, double squared_sine) {
  const int i = Next(axis_a), j = Next(i), k = Next(axis_b), l = Next(k);
  const double between = std::abs(pair.offset[j] * pair.turn(i, axis_b) - pair.offset[i] * pair.turn(j, axis_b));
  const double reach_a = pair.half_a[i] * pair.slant(j, axis_b) + pair.half_a[j] * pair.slant(i, axis_b);
  const double reach_b = pair.half_b[k] * pair.slant(axis_a, l) + pair.half_b[l] * pair.slant(axis_a, k);
  return {(between - reach_a - reach_b) / std::sqrt(squared_sine), axis_a, axis_b};
}

// The direction that parts the boxes soonest, or any that parts them by more than `gap`.
Direction BestDirection(const BoxPair& pair, double gap) {
  Direction face_a, face_b, edges;
  for (int axis = 0; axis < 3; ++axis) TakeSooner(FaceOfA(pair, axis), face_a);
  if (face_a.separation > gap) return face_a;
  for (int axis = 0; axis < 3; ++axis) TakeSooner(FaceOfB(pair, axis), face_b);
  if (face_b.separation > gap) return face_b;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double squared_sine = 1 - pair.turn(i, j) * pair.turn(i, j);
      if (squared_sine < kAlong) continue;
      TakeSooner(AcrossEdges(pair, i, j, squared_sine), edges);
      if (edges.separation > gap) return edges;
    }
  }
  return Preferred(Preferred(face_a, face_b, gap), edges, gap);
}

// Whether they just touch in faces that are parallel, and at most touch along some direction across that, too: as the
// next tile of a floor and what slides over that do. When it has come to there it lies on the tile, and does not hit
// its side.
bool LieFlush(const BoxPair& pair) {
  const double flush = std::min(kFlush, kFlushPart * std::min(pair.half_a.minCoeff(), pair.half_b.minCoeff()));
  for (int axis = 0; axis < 3; ++axis) {
    if (pair.slant.row(axis).maxCoeff() < 1 - kFlat || std::abs(FaceOfA(pair, axis).separation) > flush) continue;
    for (int across = 0; across < 3; ++across) {
      if (across != axis && FaceOfA(pair, across).separation > -flush) return true;
      if (pair.slant(axis, across) < kAcross && FaceOfB(pair, across).separation > -flush) return true;
    }
  }
  return false;
}

// A polygon over a face: across it x and y from its middle, and z above it.
struct Outline {
  // Four corners, and each side of the face cuts off at most one and makes two. Corners that coincide may seem to cross
  // a side more often; what is too many then lies where others are.
  static constexpr int kMax = 8;
  std::array<Vector3, kMax> corners;
  int count = 0;

  void Add(const Vector3& corner) {
    if (count < kMax) corners[static_cast<size_t>(count++)] = corner;
  }
  const Vector3& operator[](int i) const { return corners[static_cast<size_t>(i)]; }
};

// Cuts off what has side * p[axis] > half.
void CutSide(Outline& outline, int axis, double side, double half) {
  const auto past = [&](const Vector3& p) { return side * p[axis] - half; };
  bool is_inside = true;
  for (int i = 0; i < outline.count; ++i) is_inside &= past(outline[i]) <= 0;
  if (is_inside) return;
  Outline kept;
  for (int i = 0; i < outline.count; ++i) {
    const Vector3 &from = outline[i], &to = outline[i + 1 == outline.count ? 0 : i + 1];
    const double past_from = past(from), past_to = past(to);
    if (past_from <= 0) kept.Add(from);
    if ((past_from < 0 && past_to > 0) || (past_from > 0 && past_to < 0)) {
      kept.Add(from + past_from / (past_from - past_to) * (to - from));
    }
  }
  outline = kept;
}

// The face that a box turns to the face of another, seen from that: `pair` is from it, `axis` its normal.
Outline FacingOutline(const BoxPair& pair, int axis, double side) {
  const int x = Next(axis), y = Next(x);
  int facing = 0;
  pair.slant.row(axis).maxCoeff(&facing);
  const double toward = side * pair.turn(axis, facing) > 0 ? -1 : 1;
  const Vector3 middle = pair.offset + toward * pair.half_b[facing] * pair.turn.col(facing);
  const int u = Next(facing), v = Next(u);
  const Vector3 along_u = pair.half_b[u] * pair.turn.col(u), along_v = pair.half_b[v] * pair.turn.col(v);
  Outline outline;
  for (const Vector3& corner : {Vector3(middle + along_u + along_v), Vector3(middle - along_u + along_v),
                                Vector3(middle - along_u - along_v), Vector3(middle + along_u - along_v)}) {
    outline.Add({corner[x], corner[y], side * corner[axis] - pair.half_a[axis]});
  }
  return outline;
}

// Adds the points above and below that face of the box a of `pair`, which is at `placement`, that looks to the `side`
// of its axis. `sign` turns its normal into that of the contact.
void AddFacePoints(const BoxPair& pair, const Placement& placement, int axis, double side, double sign,
                   PointSet& points) {
  const int x = Next(axis), y = Next(x);
  Outline outline = FacingOutline(pair, axis, side);
  for (const double end : {-1.0, 1.0}) {
    CutSide(outline, 0, end, pair.half_a[x] * (1 + kSeam));
    CutSide(outline, 1, end, pair.half_a[y] * (1 + kSeam));
  }
  const Vector3 normal = sign * side * placement.rotation.col(axis);
  for (int i = 0; i < outline.count; ++i) {
    const Vector3& corner = outline[i];
    Vector3 half_way;
    half_way[x] = corner.x();
    half_way[y] = corner.y();
    half_way[axis] = side * (pair.half_a[axis] + corner.z() / 2);
    points.Add({.position = placement.Transform(half_way), .normal = normal, .depth = -corner.z()});
  }
}

// Adds the point in which edges across `normal` cross, if they do not pass beside each other.
void AddCrossing(const BoxPair& pair, const Placement& placement, const Direction& edges, const Vector3& normal,
                 PointSet& points) {
  const int i = edges.axis_a, j = edges.axis_b;
  const Vector3 along_b = pair.turn.col(j);
  Vector3 on_a = pair.half_a.cwiseProduct(normal.cwiseSign()), on_b = pair.offset;
  on_a[i] = 0;
  for (const int k : {Next(j), Next(Next(j))}) {
    on_b -= std::copysign(pair.half_b[k], normal.dot(pair.turn.col(k))) * pair.turn.col(k);
  }
  // Closest points of two lines.
  const Vector3 between = on_b - on_a;
  const double cosine = along_b[i], squared_sine = 1 - cosine * cosine;
  const double across_a = between[i], across_b = between.dot(along_b);
  const double at_a = (across_a - cosine * across_b) / squared_sine;
  const double at_b = (cosine * across_a - across_b) / squared_sine;
  if (std::abs(at_a) > pair.half_a[i] || std::abs(at_b) > pair.half_b[j]) return;
  on_a[i] = at_a;
  on_b += at_b * along_b;
  points.Add({.position = placement.Transform((on_a + on_b) / 2),
              .normal = placement.rotation * normal,
              .depth = -edges.separation});
}

// Two boxes at their places.
struct PlacedBoxes {
  const Box& a;
  const Placement& placement_a;
  const Box& b;
  const Placement& placement_b;

  BoxPair SeenFromA() const { return Seen(a, placement_a, b, placement_b); }
  BoxPair SeenFromB() const { return Seen(b, placement_b, a, placement_a); }

 private:
  static BoxPair Seen(const Box& a, const Placement& placement_a, const Box& b, const Placement& placement_b) {
    const Placement seen = placement_a.ToLocal(placement_b);
    return {a.half_extents, b.half_extents, seen.rotation, seen.rotation.cwiseAbs(), seen.position};
  }
};

// `normal` is the direction across edges: as good as that of a face, if it is as good as flat on one.
void AddEdgePoints(const PlacedBoxes& boxes, const BoxPair& pair, const Direction& edges, const Vector3& normal,
                   PointSet& points) {
  const Vector3 seen = pair.turn.transpose() * normal;
  int axis = 0;
  if (normal.cwiseAbs().maxCoeff(&axis) >= 1 - kFlat) {
    AddFacePoints(pair, boxes.placement_a, axis, std::copysign(1, normal[axis]), 1, points);
  } else if (seen.cwiseAbs().maxCoeff(&axis) >= 1 - kFlat) {
    AddFacePoints(boxes.SeenFromB(), boxes.placement_b, axis, -std::copysign(1, seen[axis]), -1, points);
  } else {
    AddCrossing(pair, boxes.placement_a, edges, normal, points);
  }
}

}  // namespace

bool AddBoxPoints(const Box& a, const Placement& placement_a, const Box& b, const Placement& placement_b, double gap,
                  PointSet& points) {
  const PlacedBoxes boxes{a, placement_a, b, placement_b};
  const BoxPair pair = boxes.SeenFromA();
  const Direction best = BestDirection(pair, gap);
  // Of boxes that are nowhere no direction is best.
  const bool is_none = best.axis_a == kNone && best.axis_b == kNone;
  if (is_none || best.separation > gap || LieFlush(pair)) return true;
  if (best.is_edges()) {
    const Vector3 normal = Vector3::Unit(best.axis_a).cross(pair.turn.col(best.axis_b)).normalized();
    AddEdgePoints(boxes, pair, best, normal.dot(pair.offset) < 0 ? Vector3(-normal) : normal, points);
  } else if (best.axis_a != kNone) {
    AddFacePoints(pair, placement_a, best.axis_a, std::copysign(1, pair.offset[best.axis_a]), 1, points);
  } else {
    const BoxPair from_b = boxes.SeenFromB();
    AddFacePoints(from_b, placement_b, best.axis_b, std::copysign(1, from_b.offset[best.axis_b]), -1, points);
  }
  // Across a gap a corner may be nearer that the face does not see.
  return best.separation > 0 ? -points.deepest() <= best.separation + Tolerance(best.separation, gap)
                             : !points.is_empty();
}

}  // namespace genphys

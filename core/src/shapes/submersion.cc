#include "shapes/submersion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include "genphys/convex_hull.h"
#include "genphys/inertia.h"

namespace genphys {
namespace {

using std::numbers::pi;

// A volume and its first moment.
struct Part {
  double volume = 0;
  Vector3 moment = Vector3::Zero();
};

// A plane in the frame of a shape; below is where dot(normal, p) <= offset.
struct Level {
  Vector3 normal;
  double offset;
};

// Ball of radius r about the origin: a cap of height r + d, where d is the depth of its centre.
// Harris and Stocker, Handbook of Mathematics and Computational Science (1998), spherical segment.
Part BallBelow(double r, const Level& level) {
  const double height = std::clamp(r + level.offset, 0.0, 2 * r);
  const double volume = pi * height * height * (3 * r - height) / 3;
  if (volume == 0) return {};
  const double distance = 3 * (2 * r - height) * (2 * r - height) / (4 * (3 * r - height));
  return {volume, -volume * distance * level.normal};
}

// The tetrahedra between a triangle and the origin add up to the volume, signed (divergence theorem).
void AddTriangle(const Vector3& a, const Vector3& b, const Vector3& c, Part& part) {
  const double volume = a.dot(b.cross(c)) / 6;
  part.volume += volume;
  part.moment += volume * (a + b + c) / 4;
}

// The part of a polygon below the level, vertex by vertex (Sutherland and Hodgman, Reentrant polygon clipping, 1974).
std::vector<Vector3> Clip(const std::vector<Vector3>& polygon, const Level& level) {
  std::vector<Vector3> below;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector3& from = polygon[i];
    const Vector3& to = polygon[(i + 1) % polygon.size()];
    const double height = level.normal.dot(from) - level.offset, height_to = level.normal.dot(to) - level.offset;
    if (height <= 0) below.push_back(from);
    if ((height < 0 && height_to > 0) || (height > 0 && height_to < 0)) {
      below.push_back(from + (to - from) * (height / (height - height_to)));
    }
  }
  return below;
}

// Measured from a point of the level, the cut itself spans no volume and needs no triangles.
Part PolyhedronBelow(const std::vector<std::vector<Vector3>>& faces, const Level& level) {
  const Vector3 origin = level.normal * level.offset;
  Part part;
  for (const std::vector<Vector3>& face : faces) {
    const std::vector<Vector3> below = Clip(face, level);
    for (size_t i = 2; i < below.size(); ++i) {
      AddTriangle(below[0] - origin, below[i - 1] - origin, below[i] - origin, part);
    }
  }
  part.moment += part.volume * origin;
  return part;
}

Part BoxBelow(const Vector3& half, const Level& level) {
  const double reach = level.normal.cwiseAbs().dot(half);
  if (level.offset <= -reach) return {};
  if (level.offset >= reach) return {8 * half.prod(), Vector3::Zero()};
  std::vector<std::vector<Vector3>> faces;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      std::vector<Vector3> face;
      for (const auto& [s, t] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        Vector3 corner;
        corner[axis] = side * half[axis];
        corner[u] = s * side * half[u];  // seen from outside, counter-clockwise on both sides
        corner[v] = t * half[v];
        face.push_back(corner);
      }
      faces.push_back(std::move(face));
    }
  }
  return PolyhedronBelow(faces, level);
}

Part HullBelow(const HullData& hull, const Level& level) {
  double low = INFINITY, high = -INFINITY;
  for (const Vector3& vertex : hull.vertices) {
    low = std::min(low, level.normal.dot(vertex));
    high = std::max(high, level.normal.dot(vertex));
  }
  if (level.offset <= low) return {};
  if (level.offset >= high) return {hull.volume, hull.volume * hull.center_of_mass};
  std::vector<std::vector<Vector3>> faces;
  for (const HullData::Face& face : hull.faces) {
    std::vector<Vector3>& corners = faces.emplace_back();
    for (const uint32_t corner : hull.CornersOf(face)) corners.push_back(hull.vertices[corner]);
  }
  return PolyhedronBelow(faces, level);
}

// Gauss and Legendre's nodes and weights of order 10 on -1 .. 1 (Abramowitz and Stegun, table 25.4).
constexpr std::array<std::pair<double, double>, 5> kNodes{{{0.1488743389816312, 0.2955242247147529},
                                                           {0.4333953941292472, 0.2692667193099963},
                                                           {0.6794095682990244, 0.2190863625159820},
                                                           {0.8650633666889845, 0.1494513491505806},
                                                           {0.9739065285171717, 0.0666713443086881}}};

// The same on both sides, as sines and cosines of that part of a quarter turn, which would take longer than all else.
struct TurnedNode {
  double sine;
  double cosine;
  double weight;
};

const std::array<TurnedNode, 2 * kNodes.size()>& TurnedNodes() {
  static const auto nodes = [] {
    std::array<TurnedNode, 2 * kNodes.size()> turned;
    size_t count = 0;
    for (const auto& [node, weight] : kNodes) {
      for (const double x : {-node, node}) {
        const double angle = pi / 2 * x;
        turned[count++] = {std::sin(angle), std::cos(angle), weight};
      }
    }
    return turned;
  }();
  return nodes;
}

// Area of a disc of radius r in which x <= d, and its first moment along x.
std::pair<double, double> DiscBelow(double r, double d) {
  const double x = std::clamp(d, -r, r);
  const double chord = std::sqrt(std::max(0.0, r * r - x * x));
  return {x * chord + r * r * (std::asin(r > 0 ? x / r : 0.0) + pi / 2), -2 * chord * chord * chord / 3};
}

// A body of revolution about z, cut into discs: `radius(z)`, at most `widest`, is its profile over the `ends` of its
// smooth pieces. Where the level leaves or enters a disc its area has an infinite slope, so pieces end there as well,
// and substituting z by its cosine takes the square root out of the integrand.
template <typename Radius>
Part TurnedBelow(Radius radius, double widest, std::vector<double> ends, const Level& level) {
  const Vector3 across(level.normal.x(), level.normal.y(), 0);
  const double tilt = across.norm(), nz = level.normal.z();
  const Vector3 direction = tilt > 0 ? Vector3(across / tilt) : Vector3::UnitX();
  const double first = ends.front(), last = ends.back();
  // All of it is above.
  if (level.offset <= std::min(nz * first, nz * last) - tilt * widest) return {};
  constexpr int kPieces = 24;
  for (int i = 1; i < kPieces; ++i) ends.push_back(first + (last - first) * i / kPieces);
  // Where the surface touches the rim of a disc: tilt * r(z) = +-(offset - nz z), found by bisection between samples.
  constexpr int kSamples = 256;
  for (const double side : {-1.0, 1.0}) {
    const auto gap = [&](double z) { return level.offset - nz * z - side * tilt * radius(z); };
    for (int i = 0; i < kSamples; ++i) {
      double low = first + (last - first) * i / kSamples, high = first + (last - first) * (i + 1) / kSamples;
      if ((gap(low) < 0) == (gap(high) < 0)) continue;
      const bool low_is_negative = gap(low) < 0;
      for (int step = 0; step < 60; ++step) {
        const double middle = (low + high) / 2;
        ((gap(middle) < 0) == low_is_negative ? low : high) = middle;
      }
      ends.push_back(low);
    }
  }
  std::sort(ends.begin(), ends.end());
  Part part;
  const auto add = [&](double z, double weight) {
    const double r = radius(z), depth = level.offset - nz * z;
    double area = pi * r * r, moment = 0;
    if (std::abs(depth) < tilt * r) {
      std::tie(area, moment) = DiscBelow(r, depth / tilt);
    } else if (depth < 0) {
      return;
    }
    part.volume += weight * area;
    part.moment += weight * (moment * direction + area * z * Vector3::UnitZ());
  };
  for (size_t i = 1; i < ends.size(); ++i) {
    const double middle = (ends[i - 1] + ends[i]) / 2, half = (ends[i] - ends[i - 1]) / 2;
    for (const auto& [sine, cosine, weight] : TurnedNodes()) {
      add(middle + half * sine, half * pi / 2 * cosine * weight);
    }
  }
  return part;
}

struct Below {
  Level level;

  Part operator()(const Sphere& sphere) const { return BallBelow(sphere.radius, level); }
  Part operator()(const Box& box) const { return BoxBelow(box.half_extents, level); }
  Part operator()(const Capsule& c) const {
    const auto radius = [&](double z) {
      const double cap = std::max(0.0, std::abs(z) - c.half_length);
      return std::sqrt(std::max(0.0, c.radius * c.radius - cap * cap));
    };
    const double end = c.half_length + c.radius;
    return TurnedBelow(radius, c.radius, {-end, -c.half_length, c.half_length, end}, level);
  }
  Part operator()(const Cylinder& c) const {
    return TurnedBelow([&](double) { return c.radius; }, c.radius, {-c.half_length, c.half_length}, level);
  }
  Part operator()(const Cone& c) const {
    const auto radius = [&](double z) { return c.radius * (c.half_length - z) / (2 * c.half_length); };
    return TurnedBelow(radius, c.radius, {-c.half_length, c.half_length}, level);
  }
  // Shrinking each axis to unit length makes it a ball, and leaves planes planes and parts of the volume the same.
  Part operator()(const Ellipsoid& e) const {
    const Vector3 scaled = e.semi_axes.cwiseProduct(level.normal);
    const double length = scaled.norm(), scale = e.semi_axes.prod();
    const Part ball = BallBelow(1, {scaled / length, level.offset / length});
    return {scale * ball.volume, scale * e.semi_axes.cwiseProduct(ball.moment)};
  }
  Part operator()(const ConvexHull& hull) const { return HullBelow(*hull.data, level); }
  // What has no volume displaces nothing.
  Part operator()(const Plane&) const { return {}; }
  Part operator()(const TriangleMesh&) const { return {}; }
  Part operator()(const Heightfield&) const { return {}; }
};

}  // namespace

Submersion Submerge(const RigidBody& body, const Pose& pose, const Vector3& normal, double offset) {
  Submersion found;
  Vector3 moment = Vector3::Zero();
  for (const Geometry& geometry : body.geometries) {
    if (geometry.is_sensor) continue;
    const Pose placed = pose.Transform(geometry.pose_in_entity);
    const Level level{placed.orientation.conjugate() * normal, offset - normal.dot(placed.position)};
    const Part part = std::visit(Below{level}, geometry.shape);
    found.volume += Volume(geometry.shape);
    found.volume_below += part.volume;
    moment += part.volume * placed.position + placed.orientation * part.moment;
  }
  if (found.volume_below > 0) found.center = moment / found.volume_below;
  return found;
}

}  // namespace genphys

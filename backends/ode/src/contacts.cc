#include "contacts.h"

#include <ode/ode.h>

#include <algorithm>
#include <array>
#include <limits>

#include "genphys/narrow_phase.h"

namespace genphys::ode_backend {
namespace {

constexpr int kPointsMax = 8;
// More than any pair of shapes gives, so that we choose what to drop and not the engine, which takes the first.
constexpr int kFoundMax = 32;

using Found = std::array<dContactGeom, kFoundMax>;

double SquaredDistance(const dContactGeom& a, const dContactGeom& b) {
  const double x = a.pos[0] - b.pos[0];
  const double y = a.pos[1] - b.pos[1];
  const double z = a.pos[2] - b.pos[2];
  return x * x + y * y + z * z;
}

// Moves to the front the deepest point, then again and again the one that is farthest from all before it.
void PutBestFirst(Found& found, int count) {
  const auto deepest = std::max_element(found.begin(), found.begin() + count,
                                        [](const auto& a, const auto& b) { return a.depth < b.depth; });
  std::swap(found[0], *deepest);
  std::array<double, kFoundMax> distances;
  distances.fill(std::numeric_limits<double>::infinity());
  for (int chosen = 1; chosen < kPointsMax; ++chosen) {
    for (int i = chosen; i < count; ++i) {
      distances[i] = std::min(distances[i], SquaredDistance(found[i], found[chosen - 1]));
    }
    const auto first = distances.begin() + chosen;
    const auto farthest = std::max_element(first, distances.begin() + count);
    std::swap(found[chosen], found[farthest - distances.begin()]);
    std::swap(*first, *farthest);
  }
}

// ODE has no direction in which to push a sphere whose centre lies on the axis of a cylinder, and tells none that is
// finite: any across the axis is as good.
Vector3 AcrossCylinder(const PlacedShape& a, const PlacedShape& b) {
  const dGeomID cylinder = dGeomGetClass(a.geom()) == dCylinderClass ? a.geom() : b.geom();
  const dReal* const rotation = dGeomGetRotation(cylinder);
  return {rotation[0], rotation[4], rotation[8]};
}

// Half-way between the surfaces, without their skins, where ODE tells on which of them its point is: what rolls has
// its radius as the lever of friction, and no skin.
void PutBetween(const PlacedShape& a, const PlacedShape& b, ContactPoint& point) {
  const Vector3 half = point.depth / 2 * point.normal;
  if (const Sphere* ball = std::get_if<Sphere>(&a.shape())) {
    point.position = a.position() + ball->radius * point.normal - half;
  } else if (const Sphere* other = std::get_if<Sphere>(&b.shape())) {
    point.position = b.position() - other->radius * point.normal + half;
  } else if (b.is_plane()) {
    point.position -= a.Skin(point.normal) * point.normal + half;
  } else if (a.is_plane()) {
    point.position += b.Skin(point.normal) * point.normal + half;
  }
}

uint32_t FindOurPoints(const PlacedShape& a, const PlacedShape& b, std::vector<ContactPoint>& points) {
  Manifold manifold;
  FindContacts(a.shape(), a.placement(), b.shape(), b.placement(), a.skin() + b.skin(), manifold);
  for (int i = 0; i < manifold.count; ++i) {
    const MeetingPoint& point = manifold.points[static_cast<size_t>(i)];
    points.push_back({.position = point.position, .normal = point.normal, .depth = point.depth});
  }
  return static_cast<uint32_t>(manifold.count);
}

}  // namespace

uint32_t FindPoints(const PlacedShape& a, const PlacedShape& b, std::vector<ContactPoint>& points) {
  if (IsForNarrowPhase(a.shape(), b.shape())) return FindOurPoints(a, b, points);
  Found found;
  // ODE's normals point into the first geometry.
  const int count = dCollide(b.geom(), a.geom(), kFoundMax, found.data(), sizeof(dContactGeom));
  if (count > kPointsMax) PutBestFirst(found, count);
  const int kept = std::min(count, kPointsMax);
  for (int i = 0; i < kept; ++i) {
    const dContactGeom& contact = found[i];
    ContactPoint& point = points.emplace_back();
    point.position = {contact.pos[0], contact.pos[1], contact.pos[2]};
    point.normal = {contact.normal[0], contact.normal[1], contact.normal[2]};
    if (!point.normal.allFinite()) point.normal = AcrossCylinder(a, b);
    point.depth = contact.depth - a.Skin(point.normal) - b.Skin(point.normal);
    PutBetween(a, b, point);
  }
  return static_cast<uint32_t>(kept);
}

}  // namespace genphys::ode_backend

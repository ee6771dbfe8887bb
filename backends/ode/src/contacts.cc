#include "contacts.h"

#include <ode/ode.h>

#include <array>
#include <span>

#include "genphys/narrow_phase.h"

namespace genphys::ode_backend {
namespace {

// More than any pair of shapes gives, so that we choose what to drop and not the engine, which takes the first.
constexpr int kFoundMax = 32;

using Found = std::array<dContactGeom, kFoundMax>;

Vector3 PositionOf(const dContactGeom& contact) { return {contact.pos[0], contact.pos[1], contact.pos[2]}; }

// Moves to the front those that are kept, and returns how many. Of two faces ODE tells every corner of what they share,
// up to eight. Where their edges lie on each other some of these are in the middle of an edge, and anywhere along it:
// where the edges cross is a matter of the last bit.
int KeepFew(Found& found, int count) {
  if (count <= Manifold::kPointsPerNormal) return count;
  std::array<MeetingPoint, kFoundMax> points;
  for (int i = 0; i < count; ++i) points[i] = {.position = PositionOf(found[i]), .depth = found[i].depth};
  const FewPoints few = ChooseFew(std::span(points).first(count));
  for (int i = 0; i < few.count; ++i) found[i] = found[few.places[i]];
  return few.count;
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

// ODE tells one point of a drum that does not stand quite straight on a plane, however near the rest of its rim is, and
// what lies on it then tips it over that point before there is another one.
bool IsDrumOnPlane(const PlacedShape& a, const PlacedShape& b) {
  return (a.is_plane() && std::holds_alternative<Cylinder>(b.shape())) ||
         (b.is_plane() && std::holds_alternative<Cylinder>(a.shape()));
}

}  // namespace

uint32_t FindPoints(const PlacedShape& a, const PlacedShape& b, std::vector<ContactPoint>& points) {
  if (IsForNarrowPhase(a.shape(), b.shape()) || IsDrumOnPlane(a, b)) return FindOurPoints(a, b, points);
  Found found;
  // ODE's normals point into the first geometry.
  const int count = dCollide(b.geom(), a.geom(), kFoundMax, found.data(), sizeof(dContactGeom));
  const int kept = KeepFew(found, count);
  for (int i = 0; i < kept; ++i) {
    const dContactGeom& contact = found[i];
    ContactPoint& point = points.emplace_back();
    point.position = PositionOf(contact);
    point.normal = {contact.normal[0], contact.normal[1], contact.normal[2]};
    if (!point.normal.allFinite()) point.normal = AcrossCylinder(a, b);
    point.depth = contact.depth - a.Skin(point.normal) - b.Skin(point.normal);
    PutBetween(a, b, point);
  }
  return static_cast<uint32_t>(kept);
}

}  // namespace genphys::ode_backend

#include "contacts.h"

#include <ode/ode.h>

#include <array>
#include <span>

#include "genphys/narrow_phase.h"

namespace genphys::ode_backend {
namespace {

// More than any pair of shapes gives that is left to ODE: four corners of a box on a plane.
constexpr int kFoundMax = 8;

Vector3 PositionOf(const dContactGeom& contact) { return {contact.pos[0], contact.pos[1], contact.pos[2]}; }

// ODE has no direction in which to push a sphere whose centre lies on the axis of a cylinder, and tells none that is
// finite: any across the axis is as good.
Vector3 AcrossCylinder(const MeetingSide& a, const MeetingSide& b) {
  const dGeomID cylinder = dGeomGetClass(a.ode.geom()) == dCylinderClass ? a.ode.geom() : b.ode.geom();
  const dReal* const rotation = dGeomGetRotation(cylinder);
  return {rotation[0], rotation[4], rotation[8]};
}

// Half-way between the surfaces, without their skins, where ODE tells on which of them its point is: what rolls has
// its radius as the lever of friction, and no skin.
void PutBetween(const MeetingSide& a, const MeetingSide& b, ContactPoint& point) {
  const Vector3 half = point.depth / 2 * point.normal;
  if (const Sphere* ball = std::get_if<Sphere>(&a.geometry.shape)) {
    point.position = a.geometry.placement.position + ball->radius * point.normal - half;
  } else if (const Sphere* other = std::get_if<Sphere>(&b.geometry.shape)) {
    point.position = b.geometry.placement.position - other->radius * point.normal + half;
  } else if (b.is_plane()) {
    point.position -= a.ode.skin() * point.normal + half;
  } else if (a.is_plane()) {
    point.position += b.ode.skin() * point.normal + half;
  }
}

void FindOurPoints(const MeetingSide& a, const MeetingSide& b, std::vector<ContactPoint>& points) {
  Manifold manifold;
  FindContacts(a.geometry.shape, a.geometry.placement, b.geometry.shape, b.geometry.placement,
               a.ode.reach() + b.ode.reach(), manifold);
  for (int i = 0; i < manifold.count; ++i) {
    const MeetingPoint& point = manifold.points[static_cast<size_t>(i)];
    points.push_back({.position = point.position, .normal = point.normal, .depth = point.depth});
  }
}

}  // namespace

void FindPoints(const MeetingSide& a, const MeetingSide& b, std::vector<ContactPoint>& points) {
  if (IsForNarrowPhase(a.geometry.shape, b.geometry.shape)) return FindOurPoints(a, b, points);
  std::array<dContactGeom, kFoundMax> found;
  // ODE's normals point into the first geometry.
  const int count = dCollide(b.ode.geom(), a.ode.geom(), kFoundMax, found.data(), sizeof(dContactGeom));
  for (const dContactGeom& contact : std::span(found).first(static_cast<size_t>(count))) {
    const double depth = contact.depth - a.ode.skin() - b.ode.skin();
    if (depth < -(a.ode.reach() + b.ode.reach())) continue;
    ContactPoint& point = points.emplace_back();
    point.position = PositionOf(contact);
    point.normal = {contact.normal[0], contact.normal[1], contact.normal[2]};
    if (!point.normal.allFinite()) point.normal = AcrossCylinder(a, b);
    point.depth = depth;
    PutBetween(a, b, point);
  }
}

}  // namespace genphys::ode_backend

#include "world.h"

#include "contacts.h"

namespace genphys::bullet_backend {

void World::FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) {
  const PlacedGeometry &first = Placed(a), &second = Placed(b);
  Manifold meeting;
  FindMeeting(first.shape, first.placement, second.shape, second.placement, meeting);
  for (const MeetingPoint& point : std::span(meeting.points).first(static_cast<size_t>(meeting.count))) {
    points.push_back({.position = point.position, .normal = point.normal, .depth = point.depth});
  }
}

}  // namespace genphys::bullet_backend

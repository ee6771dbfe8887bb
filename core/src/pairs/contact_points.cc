#include "pairs/contact_points.h"

namespace genphys {

std::span<const SolvedPoint> TurnedOf(const ContactBuffer& contacts, const ContactPair& pair) {
  const auto first = std::ranges::lower_bound(contacts.turned, pair.first_point, {}, &SolvedPoint::point);
  const uint32_t end = pair.first_point + pair.point_count;
  return {first, std::ranges::lower_bound(first, contacts.turned.end(), end, {}, &SolvedPoint::point)};
}

EventContactPoint EventPointOf(const PairRule& rule, const ContactPair& pair, const ContactPoint& point) {
  return {.position = point.position,
          .normal = point.normal,
          .depth = point.depth,
          .normal_impulse = point.normal_impulse,
          .friction_impulse = point.friction_impulse,
          .relative_velocity = point.relative_velocity,
          // At rest: that of the point is another one while it slides.
          .friction = pair.material.friction,
          .restitution = pair.material.restitution,
          .geometry_a = rule.info(pair.geometry_a).geometry_id,
          .geometry_b = rule.info(pair.geometry_b).geometry_id};
}

}  // namespace genphys

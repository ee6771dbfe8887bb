#pragma once
#include <algorithm>
#include <span>

#include "genphys/contact.h"
#include "genphys/event.h"
#include "genphys/pair_rule.h"

namespace genphys {

/// The part of a vector that lies along a surface.
inline Vector3 Across(const Vector3& vector, const Vector3& normal) { return vector - vector.dot(normal) * normal; }

/// Those of a pair in `contacts`.
inline std::span<const ContactPoint> PointsOf(const ContactBuffer& contacts, const ContactPair& pair) {
  return std::span(contacts.points).subspan(pair.first_point, pair.point_count);
}

/// Those of a pair of which `contacts` tells how they go on, as the solve left them.
std::span<const SolvedPoint> TurnedOf(const ContactBuffer& contacts, const ContactPair& pair);

/// Whether the solve that left the pair in `contacts` pressed its two against each other.
inline bool HasPressed(const ContactBuffer& contacts, const ContactPair& pair) {
  return std::ranges::any_of(PointsOf(contacts, pair),
                             [](const ContactPoint& point) { return point.normal_impulse > 0; });
}

/// What events and queries tell of a point of a pair.
EventContactPoint EventPointOf(const PairRule& rule, const ContactPair& pair, const ContactPoint& point);

}  // namespace genphys

#pragma once
#include <span>
#include <vector>

#include "impacts/impacts.h"
#include "pairs/near_pairs.h"

namespace genphys {

/// Whom bodies met on their ways.
struct Swept {
  std::vector<SweptPair> hits;
  std::vector<SweptPair> visits;  // of sensors, or by them
  std::vector<EntityRow> flyers;  // of the flight lane, into whose regions ways led; ascending
};

/// What the bodies of `ways` flew into on their ways and may be out of again, for those that went or turned so far that
/// the test at the end may have missed it. What hardly turns is taken along the chord of its way. Those that they meet
/// are taken to have gone straight, as they go now.
Swept FindSwept(const ImpactWorld& world, const NearPairs& near, std::span<const FlownWay> ways, double step_size);

}  // namespace genphys

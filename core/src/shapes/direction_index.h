#pragma once
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "absl/container/inlined_vector.h"
#include "genphys/math.h"

namespace genphys {

/// Numbers of directions by where these point, to find those that are much the same without looking at all.
class DirectionIndex {
 public:
  /// `direction` has unit length.
  void Add(const Vector3& direction, uint32_t number) {
    VisitCells(direction, 0, [&](uint64_t cell) { numbers_[cell].push_back(number); });
  }

  /// Calls visit(number) of all that differ from `direction` by less than `distance`, and of others.
  template <typename Visit>
  void VisitNear(const Vector3& direction, double distance, Visit&& visit) const {
    VisitCells(direction, distance, [&](uint64_t cell) {
      const auto found = numbers_.find(cell);
      if (found == numbers_.end()) return;
      for (const uint32_t number : found->second) visit(number);
    });
  }

 private:
  // About thrice the distance that is asked for, so that mostly one cell is looked at along each axis.
  static constexpr double kCell = 4e-3;

  template <typename Visit>
  static void VisitCells(const Vector3& direction, double distance, Visit&& visit) {
    const auto cell = [](double along) { return static_cast<int64_t>(std::floor((along + 2) / kCell)); };
    const Vector3 low = direction.array() - distance, high = direction.array() + distance;
    for (int64_t x = cell(low.x()); x <= cell(high.x()); ++x) {
      for (int64_t y = cell(low.y()); y <= cell(high.y()); ++y) {
        for (int64_t z = cell(low.z()); z <= cell(high.z()); ++z)
          visit(static_cast<uint64_t>((x << 40) + (y << 20) + z));
      }
    }
  }

  std::unordered_map<uint64_t, absl::InlinedVector<uint32_t, 2>> numbers_;
};

}  // namespace genphys

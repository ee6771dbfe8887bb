#pragma once
#include <vector>

#include "pairs/bounds_tree.h"

namespace genphys {

/// Where those are who sleep, without all else that rests. Who is found is taken out, to be found but once.
class SleeperTree {
 public:
  void Add(GeometryRow row, const Bounds& bounds) {
    if (leaves_.size() <= Index(row)) leaves_.resize(Index(row) + 1, BoundsTree::kNone);
    leaves_[Index(row)] = tree_.Insert(bounds, row, BoundsTree::kNoGroup);
  }

  /// Calls take(row) for each whose bounds overlap `bounds`, and takes those out for whom it returns true.
  template <typename Take>
  void TakeFrom(const Bounds& bounds, Take&& take) {
    taken_.clear();
    tree_.VisitOverlaps(bounds, BoundsTree::kNoGroup, [&](GeometryRow row) {
      if (take(row)) taken_.push_back(row);
    });
    for (const GeometryRow row : taken_) tree_.Remove(leaves_[Index(row)]);
  }

 private:
  BoundsTree tree_;
  std::vector<BoundsTree::Node> leaves_;  // by geometry row
  std::vector<GeometryRow> taken_;        // kept for its memory only
};

}  // namespace genphys

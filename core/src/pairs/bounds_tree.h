#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "genphys/bounds.h"
#include "genphys/contact.h"
#include "genphys/query.h"

namespace genphys {

/// A ray made ready to be tested against many boxes.
class BoxRay {
 public:
  explicit BoxRay(const Ray& ray);
  /// The fraction at which the ray comes into `box`, or more than one if it does not. May come into a box that it
  /// passes within rounding, which is zero at its start.
  double EntryInto(const Bounds& box) const;
  /// How far to look for what lies within that fraction, whatever was rounded.
  static double Widened(double fraction) { return fraction * (1 + kRounding) + kRounding; }

 private:
  static constexpr double kRounding = 1e-12;  // far more than a fraction is rounded by

  Vector3 origin_;
  Vector3 inverse_;
};

/// A balanced tree of boxes, one leaf for each geometry. Leaves may belong to groups, of which a search can leave one
/// out and then does not go down to its members where they are among themselves. What it finds does not depend on how
/// it came about, only the order in which it finds it does. Insertion, removal and queries take logarithmic time; where
/// most leaves are new or moved, all are sorted at once.
class BoundsTree {
 public:
  using Node = int32_t;
  static constexpr Node kNone = -1;

  /// Of leaves that belong to none.
  static constexpr uint32_t kNoGroup = 0;

  /// A leaf that stays valid until it is removed.
  Node Insert(const Bounds& box, GeometryRow row, uint32_t group);
  void Remove(Node leaf);

  /// Gives a leaf another box where it is in the tree. It is found at once, but searches take longer until Tidy().
  void Move(Node leaf, const Bounds& box);
  /// Finds all that moved a place where they are, or sorts all anew if many moved or came.
  void Tidy();
  /// Sorts all anew if most came since that was done last, and Tidy() would do so when only a few more have come.
  void TidyNewcomers();
  /// Shifts all that is in it.
  void Shift(const Vector3& by);

  /// Around all leaves; of none the null box.
  Bounds bounds() const { return root_ == kNone ? Bounds{} : nodes_[root_].box; }
  bool empty() const { return root_ == kNone; }

  /// Calls visit(row) for each leaf whose box overlaps `box`, but for those of the group `left_out`.
  template <typename Visit>
  void VisitOverlaps(const Bounds& box, uint32_t left_out, Visit&& visit) const {
    VisitIf([&](const Bounds& candidate) { return candidate.Overlaps(box); }, left_out, visit);
  }

  /// Calls visit(row) for each leaf whose box is no farther from `box` than `within` (m), which `visit` may lower
  /// meanwhile; the nearer ones mostly come first. May do so for one that is farther within rounding.
  template <typename Visit>
  void VisitNearest(const Bounds& box, const double& within, Visit&& visit) const {
    const auto reach = [&] { return std::max(within, 0.0) * (1 + kRounding); };
    VisitInOrder([&](const Bounds& candidate) { return candidate.SquaredGap(box); },
                 [&](double gap) { return gap <= reach() * reach(); }, visit);
  }

  /// Calls visit(a, b) once for each two leaves whose boxes overlap, unless they belong to the same group.
  template <typename Visit>
  void VisitPairs(Visit&& visit) const {
    if (root_ != kNone) VisitPairsIn(root_, visit);
  }

  /// Calls visit(row) for each leaf whose box `ray` meets in its first `fraction`, which `visit` may lower meanwhile;
  /// the nearer ones mostly come first.
  template <typename Visit>
  void VisitRay(const BoxRay& ray, const double& fraction, Visit&& visit) const {
    VisitInOrder([&](const Bounds& candidate) { return ray.EntryInto(candidate); },
                 [&](double entry) { return entry <= BoxRay::Widened(fraction); }, visit);
  }

 private:
  struct Entry {
    Bounds box;
    Node parent = kNone;
    Node children[2] = {kNone, kNone};
    int32_t height = 0;         // of a leaf: zero
    uint32_t group = kNoGroup;  // of all below, if it is the same
    GeometryRow row{};
    bool is_out_of_place = false;

    bool is_leaf() const { return height == 0; }
  };

  // Of a distance: far more than what a gap is rounded by.
  static constexpr double kRounding = 1e-12;

  // Balance keeps the height below 1.45 log2(leaves), and a walk keeps one node for each level.
  static constexpr size_t kWalkSizeMax = 64;

  template <typename Test, typename Visit>
  void VisitIf(Test&& test, uint32_t left_out, Visit&& visit) const {
    if (root_ == kNone) return;
    std::array<Node, kWalkSizeMax> open;
    size_t count = 0;
    open[count++] = root_;
    while (count > 0) {
      const Entry& entry = nodes_[open[--count]];
      if (!test(entry.box) || (entry.group != kNoGroup && entry.group == left_out)) continue;
      if (entry.is_leaf()) {
        visit(entry.row);
      } else {
        open[count++] = entry.children[0];
        open[count++] = entry.children[1];
      }
    }
  }

  // Where is_wanted(key_of(box)), the one of two children with the smaller key first.
  template <typename KeyOf, typename IsWanted, typename Visit>
  void VisitInOrder(KeyOf&& key_of, IsWanted&& is_wanted, Visit&& visit) const {
    if (root_ == kNone) return;
    std::array<std::pair<double, Node>, kWalkSizeMax> open;
    size_t count = 0;
    const auto push = [&](Node node) { open[count++] = {key_of(nodes_[node].box), node}; };
    push(root_);
    while (count > 0) {
      const auto [key, node] = open[--count];
      if (!is_wanted(key)) continue;
      const Entry& entry = nodes_[node];
      if (entry.is_leaf()) {
        visit(entry.row);
        continue;
      }
      push(entry.children[0]);
      push(entry.children[1]);
      if (open[count - 1].first > open[count - 2].first) std::swap(open[count - 1], open[count - 2]);
    }
  }

  // Pairs of leaves below `node`.
  template <typename Visit>
  void VisitPairsIn(Node node, Visit& visit) const {
    const Entry& entry = nodes_[node];
    if (entry.is_leaf() || entry.group != kNoGroup) return;
    const auto [first, second] = entry.children;
    VisitPairsIn(first, visit);
    VisitPairsIn(second, visit);
    VisitPairsOf(first, second, visit);
  }

  // Pairs of a leaf below `a` and one below `b`.
  template <typename Visit>
  void VisitPairsOf(Node a, Node b, Visit& visit) const {
    const Entry &first = nodes_[a], &second = nodes_[b];
    if (!first.box.Overlaps(second.box) || (first.group != kNoGroup && first.group == second.group)) return;
    if (first.is_leaf() && second.is_leaf()) {
      visit(first.row, second.row);
    } else if (first.height >= second.height) {
      for (const Node child : first.children) VisitPairsOf(child, b, visit);
    } else {
      for (const Node child : second.children) VisitPairsOf(a, child, visit);
    }
  }

  // One that is to be sorted into a new tree.
  struct Sprout {
    Vector3 center;  // m, twice
    Node leaf = kNone;
  };

  Node Allocate();
  void Hang(Node leaf);
  void Unhang(Node leaf);
  void Rebuild();
  Node Grow(std::span<Sprout> sprouts);
  Node FindSibling(const Bounds& box) const;
  double Growth(Node node, const Bounds& box) const;
  void Replace(Node parent, Node child, Node by);
  bool Update(Node node);
  bool Balance(Node node);
  void RepairUpwards(Node node);

  std::vector<Entry> nodes_;
  std::vector<Node> free_;
  std::vector<Node> out_of_place_;  // and some that are no longer
  std::vector<Sprout> sprouts_;     // kept for its memory only
  size_t leaves_ = 0;
  size_t hung_ = 0;  // leaves that found a place since all were sorted
  Node root_ = kNone;
};

}  // namespace genphys

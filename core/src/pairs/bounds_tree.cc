#include "pairs/bounds_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace genphys {
namespace {

// All are sorted anew where more than one in so many leaves moved: to find places for these would take longer.
constexpr size_t kRebuildFrom = 2;
// What is left of a tree that had more leaves is gone through by itself: a step in which one flies among 10,000 that
// sleep would otherwise go through the room of all of them, which is more than a cache holds.
constexpr size_t kRoomy = 4;

}  // namespace

BoxRay::BoxRay(const Ray& ray) : origin_(ray.origin), inverse_(ray.translation.cwiseInverse()) {}

double BoxRay::EntryInto(const Bounds& box) const {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  double enter = -kRounding, leave = Widened(1);
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(inverse_[axis])) {
      if (origin_[axis] < box.min[axis] || origin_[axis] > box.max[axis]) return kNever;
      continue;
    }
    const double to_low = (box.min[axis] - origin_[axis]) * inverse_[axis];
    const double to_high = (box.max[axis] - origin_[axis]) * inverse_[axis];
    enter = std::max(enter, std::min(to_low, to_high));
    leave = std::min(leave, std::max(to_low, to_high));
  }
  return enter <= leave ? enter : kNever;
}

BoundsTree::Node BoundsTree::Insert(const Bounds& box, GeometryRow row, uint32_t group) {
  const Node leaf = Allocate();
  nodes_[leaf] = Entry{.box = box, .group = group, .row = row};
  Hang(leaf);
  ++leaves_;
  return leaf;
}

void BoundsTree::Remove(Node leaf) {
  Unhang(leaf);
  nodes_[leaf].is_out_of_place = false;
  free_.push_back(leaf);
  --leaves_;
}

void BoundsTree::Move(Node leaf, const Bounds& box) {
  Entry& entry = nodes_[leaf];
  entry.box = box;
  for (Node node = entry.parent; node != kNone && !nodes_[node].box.Contains(box); node = nodes_[node].parent) {
    nodes_[node].box = nodes_[node].box.Union(box);
  }
  if (!std::exchange(entry.is_out_of_place, true)) out_of_place_.push_back(leaf);
}

void BoundsTree::Tidy() {
  // A tree that grew leaf by leaf is searched up to ten times as long as one that was sorted as a whole.
  if (hung_ > leaves_ || kRebuildFrom * out_of_place_.size() > leaves_) {
    Rebuild();
  } else {
    for (const Node leaf : out_of_place_) {
      if (!std::exchange(nodes_[leaf].is_out_of_place, false)) continue;
      Unhang(leaf);
      Hang(leaf);
    }
  }
  out_of_place_.clear();
}

void BoundsTree::TidyNewcomers() {
  if (kRebuildFrom * hung_ <= leaves_) return;
  Rebuild();
  out_of_place_.clear();
}

void BoundsTree::Shift(const Vector3& by) {
  // Rounding keeps the order of numbers: whatever lay in a box does.
  const auto shift = [&](Entry& entry) { entry.box = entry.box.Shifted(by); };
  if (nodes_.size() <= kRoomy * leaves_) {
    for (Entry& entry : nodes_) shift(entry);
    return;
  }
  std::vector<Node> open;
  if (root_ != kNone) open.push_back(root_);
  while (!open.empty()) {
    Entry& entry = nodes_[open.back()];
    open.pop_back();
    shift(entry);
    if (!entry.is_leaf()) open.insert(open.end(), {entry.children[0], entry.children[1]});
  }
}

// Makes the leaf a neighbour of another.
void BoundsTree::Hang(Node leaf) {
  ++hung_;
  if (root_ == kNone) {
    root_ = leaf;
    nodes_[leaf].parent = kNone;
    return;
  }
  const Node sibling = FindSibling(nodes_[leaf].box);
  const Node joint = Allocate();
  const Node parent = nodes_[sibling].parent;
  nodes_[joint] = {.parent = parent, .children = {sibling, leaf}};
  Replace(parent, sibling, joint);
  nodes_[sibling].parent = joint;
  nodes_[leaf].parent = joint;
  Update(joint);
  RepairUpwards(parent);
}

void BoundsTree::Unhang(Node leaf) {
  const Node parent = nodes_[leaf].parent;
  if (parent == kNone) {
    root_ = kNone;
    return;
  }
  const Entry& entry = nodes_[parent];
  const Node sibling = entry.children[entry.children[0] == leaf ? 1 : 0];
  const Node grandparent = entry.parent;
  Replace(grandparent, parent, sibling);
  nodes_[sibling].parent = grandparent;
  free_.push_back(parent);
  RepairUpwards(grandparent);
}

void BoundsTree::Rebuild() {
  hung_ = 0;
  sprouts_.clear();
  std::vector<Node> open;
  if (root_ != kNone) open.push_back(root_);
  while (!open.empty()) {
    const Node node = open.back();
    open.pop_back();
    Entry& entry = nodes_[node];
    if (entry.is_leaf()) {
      entry.is_out_of_place = false;
      sprouts_.push_back({entry.box.min + entry.box.max, node});
    } else {
      open.insert(open.end(), {entry.children[1], entry.children[0]});
      free_.push_back(node);
    }
  }
  root_ = sprouts_.empty() ? kNone : Grow(sprouts_);
  if (root_ != kNone) nodes_[root_].parent = kNone;
}

// A tree of these, of which each half has the same number: no other shape is as low.
BoundsTree::Node BoundsTree::Grow(std::span<Sprout> sprouts) {
  if (sprouts.size() == 1) return sprouts.front().leaf;
  Bounds centers{sprouts.front().center, sprouts.front().center};
  for (const Sprout& sprout : sprouts) centers = centers.Union({sprout.center, sprout.center});
  Eigen::Index axis = 0;
  (centers.max - centers.min).maxCoeff(&axis);
  const size_t half = sprouts.size() / 2;
  std::nth_element(sprouts.begin(), sprouts.begin() + static_cast<ptrdiff_t>(half), sprouts.end(),
                   [axis](const Sprout& a, const Sprout& b) { return a.center[axis] < b.center[axis]; });
  const Node node = Allocate();
  const Node first = Grow(sprouts.first(half)), second = Grow(sprouts.subspan(half));
  nodes_[node] = {.children = {first, second}};
  nodes_[first].parent = nodes_[second].parent = node;
  Update(node);
  return node;
}

BoundsTree::Node BoundsTree::Allocate() {
  if (free_.empty()) {
    nodes_.emplace_back();
    return static_cast<Node>(nodes_.size()) - 1;
  }
  const Node node = free_.back();
  free_.pop_back();
  return node;
}

// Greedy descent to where the surface of the boxes grows least: surface is what the chance of a visit is proportional
// to. It always ends at a leaf, for an insertion further up would unbalance the tree by more than one rotation repairs.
BoundsTree::Node BoundsTree::FindSibling(const Bounds& box) const {
  Node node = root_;
  while (!nodes_[node].is_leaf()) {
    const auto [first, second] = nodes_[node].children;
    node = Growth(first, box) <= Growth(second, box) ? first : second;
  }
  return node;
}

double BoundsTree::Growth(Node node, const Bounds& box) const {
  const Bounds& own = nodes_[node].box;
  return own.Union(box).HalfArea() - own.HalfArea();
}

void BoundsTree::Replace(Node parent, Node child, Node by) {
  if (parent == kNone) {
    root_ = by;
  } else {
    Entry& entry = nodes_[parent];
    entry.children[entry.children[0] == child ? 0 : 1] = by;
  }
}

// Whether that changed anything.
bool BoundsTree::Update(Node node) {
  Entry& entry = nodes_[node];
  const Entry& first = nodes_[entry.children[0]];
  const Entry& second = nodes_[entry.children[1]];
  const Bounds box = first.box.Union(second.box);
  const int32_t height = 1 + std::max(first.height, second.height);
  const uint32_t group = first.group == second.group ? first.group : kNoGroup;
  const bool is_same =
      entry.box.Contains(box) && box.Contains(entry.box) && entry.height == height && entry.group == group;
  entry.box = box;
  entry.height = height;
  entry.group = group;
  return !is_same;
}

// Where one side is two levels taller, its root takes the place of `node`, which takes the lower grandchild in return.
// Whether that had to be.
bool BoundsTree::Balance(Node node) {
  Entry& entry = nodes_[node];
  const int32_t difference = nodes_[entry.children[1]].height - nodes_[entry.children[0]].height;
  if (difference >= -1 && difference <= 1) return false;
  const int side = difference > 0 ? 1 : 0;
  const Node tall = entry.children[side];
  Entry& lifted = nodes_[tall];
  const int taller = nodes_[lifted.children[0]].height >= nodes_[lifted.children[1]].height ? 0 : 1;
  const Node kept = lifted.children[taller];
  const Node given = lifted.children[1 - taller];

  lifted.parent = entry.parent;
  Replace(entry.parent, node, tall);
  lifted.children[0] = node;
  lifted.children[1] = kept;
  entry.parent = tall;
  entry.children[side] = given;
  nodes_[given].parent = node;
  Update(node);
  Update(tall);
  return true;
}

// From a node whose children changed, as far as something changes.
void BoundsTree::RepairUpwards(Node node) {
  while (node != kNone) {
    // Balancing puts another node here, whose parent is the one to go on with.
    const Node parent = nodes_[node].parent;
    const bool is_changed = Update(node);
    if (!Balance(node) && !is_changed) return;
    node = parent;
  }
}

}  // namespace genphys

#include "bounds_tree.h"

#include <algorithm>
#include <cmath>

namespace genphys {

BoxRay::BoxRay(const Ray& ray) : origin_(ray.origin), inverse_(ray.translation.cwiseInverse()) {}

bool BoxRay::Meets(const Bounds& box, double fraction) const {
  // Widened by what rounding can take away from a fraction.
  constexpr double kRounding = 1e-12;
  double enter = -kRounding;
  double leave = fraction * (1 + kRounding) + kRounding;
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(inverse_[axis])) {
      if (origin_[axis] < box.min[axis] || origin_[axis] > box.max[axis]) return false;
      continue;
    }
    const double to_low = (box.min[axis] - origin_[axis]) * inverse_[axis];
    const double to_high = (box.max[axis] - origin_[axis]) * inverse_[axis];
    enter = std::max(enter, std::min(to_low, to_high));
    leave = std::min(leave, std::max(to_low, to_high));
  }
  return enter <= leave;
}

BoundsTree::Node BoundsTree::Insert(const Bounds& box, GeometryRow row, uint32_t group) {
  const Node leaf = Allocate();
  nodes_[leaf] = Entry{.box = box, .group = group, .row = row};
  if (root_ == kNone) {
    root_ = leaf;
    return leaf;
  }
  const Node sibling = FindSibling(box);
  const Node joint = Allocate();
  const Node parent = nodes_[sibling].parent;
  nodes_[joint] = {.box = box, .parent = parent, .children = {sibling, leaf}, .height = 1};
  Replace(parent, sibling, joint);
  nodes_[sibling].parent = joint;
  nodes_[leaf].parent = joint;
  RepairUpwards(joint);
  return leaf;
}

void BoundsTree::Remove(Node leaf) {
  const Node parent = nodes_[leaf].parent;
  free_.push_back(leaf);
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

void BoundsTree::Update(Node node) {
  Entry& entry = nodes_[node];
  const Entry& first = nodes_[entry.children[0]];
  const Entry& second = nodes_[entry.children[1]];
  entry.box = first.box.Union(second.box);
  entry.height = 1 + std::max(first.height, second.height);
  entry.group = first.group == second.group ? first.group : kNoGroup;
}

// Where one side is two levels taller, its root takes the place of `node`, which takes the lower grandchild in return.
void BoundsTree::Balance(Node node) {
  Entry& entry = nodes_[node];
  const int32_t difference = nodes_[entry.children[1]].height - nodes_[entry.children[0]].height;
  if (difference >= -1 && difference <= 1) return;
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
}

void BoundsTree::RepairUpwards(Node node) {
  while (node != kNone) {
    // Balancing puts another node here, whose parent is the one to go on with.
    const Node parent = nodes_[node].parent;
    Update(node);
    Balance(node);
    node = parent;
  }
}

}  // namespace genphys

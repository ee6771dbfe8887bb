// The tree of boxes, held against looking at each box.
#include "core/src/pairs/bounds_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace genphys {
namespace {

// Boxes of all sizes in a tree and in a list, each the same at any time.
class Thicket {
 public:
  struct Leaf {
    BoundsTree::Node node;
    Bounds box;
    uint32_t group;
  };
  using Pairs = std::vector<std::pair<uint32_t, uint32_t>>;

  BoundsTree& tree() { return tree_; }

  void Insert() {
    const Bounds box = NewBox();
    const auto group = static_cast<uint32_t>(generator_() % 4);  // of which one is none
    leaves_[next_] = {tree_.Insert(box, GeometryRow{next_}, group), box, group};
    ++next_;
  }
  void Remove() {
    const auto leaf = Any();
    tree_.Remove(leaf->second.node);
    leaves_.erase(leaf);
  }
  void Move() {
    const auto leaf = Any();
    leaf->second.box = NewBox();
    tree_.Move(leaf->second.node, leaf->second.box);
  }
  void Shift() {
    const Vector3 by(Number(), Number(), Number());
    for (auto& [row, leaf] : leaves_) leaf.box = leaf.box.Shifted(by);
    tree_.Shift(by);
  }
  size_t size() const { return leaves_.size(); }

  void ExpectOverlapsAreFound() {
    const Bounds box = NewBox();
    const auto left_out = static_cast<uint32_t>(generator_() % 4);
    std::vector<uint32_t> found, expected;
    tree_.VisitOverlaps(box, left_out, [&](GeometryRow row) { found.push_back(Index(row)); });
    std::sort(found.begin(), found.end());
    for (const auto& [row, leaf] : leaves_) {
      if (leaf.box.Overlaps(box) && (leaf.group == BoundsTree::kNoGroup || leaf.group != left_out))
        expected.push_back(row);
    }
    EXPECT_EQ(found, expected);
  }

  void ExpectPairsAreFound() {
    Pairs found, expected;
    tree_.VisitPairs([&](GeometryRow a, GeometryRow b) { found.push_back(std::minmax(Index(a), Index(b))); });
    std::sort(found.begin(), found.end());
    for (auto a = leaves_.begin(); a != leaves_.end(); ++a) {
      for (auto b = std::next(a); b != leaves_.end(); ++b) {
        const bool is_same_group = a->second.group != BoundsTree::kNoGroup && a->second.group == b->second.group;
        if (!is_same_group && a->second.box.Overlaps(b->second.box)) expected.push_back({a->first, b->first});
      }
    }
    EXPECT_EQ(found, expected);
  }

  // By where it comes into them, within rounding.
  void ExpectRaysMeetThem() {
    const Ray ray{Vector3(8 * Number(), 8 * Number(), 8 * Number()), Vector3(8 * Number(), 8 * Number(), 8 * Number())};
    const double fraction = Number() / 2 + 0.5;
    std::vector<uint32_t> found, expected;
    tree_.VisitRay(BoxRay(ray), fraction, [&](GeometryRow row) { found.push_back(Index(row)); });
    std::sort(found.begin(), found.end());
    for (const auto& [row, leaf] : leaves_) {
      // Of slabs, one after the other.
      double enter = 0, leave = fraction;
      for (int axis = 0; axis < 3; ++axis) {
        const double low = (leaf.box.min[axis] - ray.origin[axis]) / ray.translation[axis];
        const double high = (leaf.box.max[axis] - ray.origin[axis]) / ray.translation[axis];
        enter = std::max(enter, std::min(low, high));
        leave = std::min(leave, std::max(low, high));
      }
      if (enter <= leave) expected.push_back(row);
    }
    EXPECT_EQ(found, expected);
  }

  void ExpectBoundsAreTight() {
    ASSERT_EQ(tree_.empty(), leaves_.empty());
    if (leaves_.empty()) return;
    Bounds all = leaves_.begin()->second.box;
    for (const auto& [row, leaf] : leaves_) all = all.Union(leaf.box);
    EXPECT_EQ(tree_.bounds().min, all.min);
    EXPECT_EQ(tree_.bounds().max, all.max);
  }

 private:
  double Number() { return std::uniform_real_distribution<double>(-1, 1)(generator_); }
  Bounds NewBox() {
    const Vector3 center(8 * Number(), 8 * Number(), 8 * Number());
    return Bounds{center, center}.Widened(std::exp(2 * Number() - 1));
  }
  std::map<uint32_t, Leaf>::iterator Any() {
    return std::next(leaves_.begin(), static_cast<ptrdiff_t>(generator_() % leaves_.size()));
  }

  BoundsTree tree_;
  std::map<uint32_t, Leaf> leaves_;  // by geometry row
  uint32_t next_ = 0;
  std::mt19937 generator_{1};
};

class BoundsTreeOf : public testing::TestWithParam<int> {};

// How many of a hundred move between two searches: few find a place of their own, many are sorted anew.
INSTANTIATE_TEST_SUITE_P(Moving, BoundsTreeOf, testing::Values(1, 10, 30, 100));

TEST_P(BoundsTreeOf, FindsWhatALookAtEachBoxFinds) {
  Thicket thicket;
  for (int i = 0; i < 100; ++i) thicket.Insert();
  for (int round = 0; round < 50; ++round) {
    SCOPED_TRACE(round);
    for (int i = 0; i < GetParam(); ++i) thicket.Move();
    // Also before they have a new place.
    thicket.ExpectOverlapsAreFound();
    thicket.ExpectPairsAreFound();
    for (int i = 0; i < 5; ++i) thicket.Remove();
    for (int i = 0; i < 5; ++i) thicket.Insert();
    thicket.tree().Tidy();
    if (round % 3 == 0) thicket.tree().TidyNewcomers();
    if (round % 5 == 0) thicket.Shift();
    for (int i = 0; i < 10; ++i) thicket.ExpectOverlapsAreFound();
    for (int i = 0; i < 10; ++i) thicket.ExpectRaysMeetThem();
    thicket.ExpectPairsAreFound();
    thicket.ExpectBoundsAreTight();
  }
}

// Of some, few are left.
TEST_P(BoundsTreeOf, ShiftsWhatIsLeft) {
  Thicket thicket;
  for (int i = 0; i < 100; ++i) thicket.Insert();
  for (int i = 1; i < GetParam(); ++i) thicket.Remove();
  for (int round = 0; round < 3; ++round) {
    thicket.Shift();
    thicket.ExpectOverlapsAreFound();
    thicket.ExpectRaysMeetThem();
    thicket.ExpectPairsAreFound();
    thicket.ExpectBoundsAreTight();
    thicket.Insert();
  }
}

TEST_P(BoundsTreeOf, IsEmptyAfterAllAreRemovedAndFillsAgain) {
  Thicket thicket;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 20; ++i) thicket.Insert();
    for (int i = 0; i < GetParam(); ++i) thicket.Move();
    if (round % 2 == 0) thicket.tree().Tidy();
    while (thicket.size() > 0) {
      thicket.Remove();
      thicket.tree().Tidy();
      thicket.ExpectBoundsAreTight();
      thicket.ExpectPairsAreFound();
    }
  }
}

// One flies where all others sleep, and goes into them.
TEST(BoundsTree, ShiftsOneOfManyWhoLeftInNoTime) {
  BoundsTree tree;
  std::vector<BoundsTree::Node> leaves;
  for (uint32_t i = 0; i < 20'000; ++i) {
    const Vector3 center(i % 100, i / 100, 0);
    leaves.push_back(tree.Insert(Bounds{center, center}.Widened(0.4), GeometryRow{i}, BoundsTree::kNoGroup));
  }
  const auto time_of_shifts = [&] {
    const std::clock_t before = std::clock();
    for (int i = 0; i < 200; ++i) tree.Shift({0.1, 0, 0});
    return static_cast<double>(std::clock() - before);
  };
  const double of_all = time_of_shifts();
  while (leaves.size() > 1) {
    tree.Remove(leaves.back());
    leaves.pop_back();
  }
  EXPECT_LT(time_of_shifts(), of_all / 10);
}

// A long ray through a field ends at the first one, and hardly looks at those behind.
TEST(BoundsTree, LooksAtWhatIsNearAlongARayFirst) {
  constexpr int kMany = 10'000;
  BoundsTree tree;
  for (int i = 0; i < kMany; ++i) {
    const Vector3 center(i % 100, i / 100, 0);
    tree.Insert(Bounds{center, center}.Widened(0.4), GeometryRow{static_cast<uint32_t>(i)}, BoundsTree::kNoGroup);
  }
  tree.Tidy();
  for (const double sign : {1.0, -1.0}) {
    const Ray ray{Vector3(50, 50, 0) - sign * Vector3(80, 3, 0), sign * Vector3(160, 6, 0)};
    const BoxRay boxes(ray);
    double fraction = 1;
    int looks = 0;
    tree.VisitRay(boxes, fraction, [&](GeometryRow row) {
      ++looks;
      const Vector3 center(Index(row) % 100, Index(row) / 100, 0);
      fraction = std::min(fraction, boxes.EntryInto(Bounds{center, center}.Widened(0.4)));
    });
    EXPECT_LE(looks, 10);
  }
}

}  // namespace
}  // namespace genphys

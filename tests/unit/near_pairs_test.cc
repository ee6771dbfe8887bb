// Which points a part of the pairs gets anew, held against what all of them get.
#include "core/src/pairs/near_pairs.h"

#include <gtest/gtest.h>

#include <random>

#include "bullet_test_bench.h"

namespace genphys {
namespace {

using bullet_test::Bench;

// Boxes and balls, most of them in touch with some others.
class Heap {
 public:
  Heap() {
    bench_.Add(Plane{}, Vector3::Zero(), MotionType::kStatic);
    for (int i = 0; i < kBodies; ++i) {
      const Shape shape = i % 3 == 0 ? Shape(Sphere{0.5}) : Shape(Box{{0.5, 0.4, 0.3}});
      bodies_.push_back(bench_.Add(shape, Place()));
    }
    moved_.Resize(bench_.state.rows());
  }

  Bench& bench() { return bench_; }
  const RowMarks& moved() const { return moved_; }

  void MoveSome(int count) {
    moved_.Clear();
    for (int i = 0; i < count; ++i) {
      const EntityRow row = bodies_[generator_() % bodies_.size()];
      bench_.Put(row, {Place(), Quaternion(Number(), Number(), Number(), Number()).normalized()});
      moved_.Mark(row);
    }
  }

 private:
  static constexpr int kBodies = 60;
  static constexpr double kReach = 2.5;  // m

  double Number() { return std::uniform_real_distribution<double>(-1, 1)(generator_); }
  Vector3 Place() { return {kReach * Number(), kReach * Number(), 0.5 + kReach * std::abs(Number())}; }

  Bench bench_;
  std::vector<EntityRow> bodies_;
  RowMarks moved_;
  std::mt19937 generator_{1};
};

void ExpectSame(const ContactBuffer& found, const ContactBuffer& all) {
  ASSERT_EQ(found.pairs.size(), all.pairs.size());
  ASSERT_EQ(found.points.size(), all.points.size());
  for (size_t i = 0; i < all.pairs.size(); ++i) {
    ASSERT_EQ(found.pairs[i].geometry_a, all.pairs[i].geometry_a) << "pair " << i;
    ASSERT_EQ(found.pairs[i].geometry_b, all.pairs[i].geometry_b) << "pair " << i;
    ASSERT_EQ(found.pairs[i].first_point, all.pairs[i].first_point) << "pair " << i;
    ASSERT_EQ(found.pairs[i].point_count, all.pairs[i].point_count) << "pair " << i;
  }
  for (size_t i = 0; i < all.points.size(); ++i) {
    ASSERT_EQ(found.points[i].position, all.points[i].position) << "point " << i;
    ASSERT_EQ(found.points[i].depth, all.points[i].depth) << "point " << i;
  }
}

TEST(NearPairs, FindForThoseWhoMovedWhatTheyFindForAll) {
  Heap heap;
  Bench& bench = heap.bench();
  bench.Collide();
  ASSERT_GT(bench.contacts.pairs.size(), 60u);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    // Several times before all is put in order, as impacts one after the other do.
    for (int wave = 0; wave <= round % 4; ++wave) {
      heap.MoveSome(1 + round % 7);
      bench.near.CollideMoved(bench.rule, *bench.world, heap.moved(), bench.contacts);
    }
    bench.near.PutInOrder(bench.contacts);
    ContactBuffer all;
    bench.near.Collide(bench.rule, *bench.world, all);
    ExpectSame(bench.contacts, all);
  }
}

TEST(NearPairs, LeaveAloneWhatHasNobodyWhoMoved) {
  Heap heap;
  Bench& bench = heap.bench();
  bench.Collide();
  for (ContactPoint& point : bench.contacts.points) point.friction = 7;
  heap.MoveSome(3);
  bench.near.CollideMoved(bench.rule, *bench.world, heap.moved(), bench.contacts);
  bench.near.PutInOrder(bench.contacts);
  size_t old = 0;
  for (const ContactPair& pair : bench.contacts.pairs) {
    const bool is_moved = heap.moved()[pair.entity_a] || heap.moved()[pair.entity_b];
    old += is_moved ? 0 : 1;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      ASSERT_EQ(bench.contacts.points[i].friction, is_moved ? 0 : 7);
    }
  }
  EXPECT_GT(old, bench.contacts.pairs.size() / 2);
}

}  // namespace
}  // namespace genphys

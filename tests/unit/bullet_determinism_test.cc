#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "bullet_test_bench.h"

namespace genphys {
namespace {

using namespace bullet_test;

void BuildHeap(Bench& bench) {
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  const std::vector<Shape> shapes{Box{{0.4, 0.35, 0.45}}, Sphere{0.4}, Capsule{0.25, 0.2}, Cylinder{0.3, 0.4}};
  for (size_t i = 0; i < 36; ++i) {
    const auto column = static_cast<double>(i % 3), line = static_cast<double>(i / 3 % 3);
    const auto layer = static_cast<double>(i / 9);
    bench.Add(shapes[i % 4], {0.9 * column + 0.05 * layer, 0.9 * line, 0.6 + 1.1 * layer});
  }
}

TEST(BulletDeterminism, GivesTwoWorldsOnTwoThreadsTheBitsTheyHaveAlone) {
  Bench alone, left, right;
  for (Bench* bench : {&alone, &left, &right}) BuildHeap(*bench);
  alone.Run(240);
  ASSERT_GT(alone.contacts.points.size(), 20u);

  std::thread other([&] { left.Run(240); });
  right.Run(240);
  other.join();

  for (const Bench* bench : {&left, &right}) {
    EXPECT_EQ(bench->state.positions, alone.state.positions);
    EXPECT_EQ(bench->state.orientations, alone.state.orientations);
    EXPECT_EQ(bench->Saved(), alone.Saved());
  }
}

TEST(BulletDeterminism, DoesNotDependOnWhatWasThereBefore) {
  Bench plain, used;
  BuildHeap(plain);
  BuildHeap(used);
  for (int i = 0; i < 100; ++i) {
    const EntityRow guest = used.Add(kUnitBall, {0.1 * i, 0, 10.0 + i});
    used.Collide();
    used.Remove(guest);
  }
  const std::vector<EntityRow> all = used.moving;
  for (const EntityRow row : all) used.SetActive(row, false);
  used.Collide();
  for (auto row = all.rbegin(); row != all.rend(); ++row) used.SetActive(*row, true);

  plain.Run(240);
  used.Run(240);

  EXPECT_EQ(used.state.positions.leftCols(plain.state.rows()), plain.state.positions);
  EXPECT_EQ(used.Saved(), plain.Saved());
}

TEST(BulletDeterminism, IsNotDisturbedByCollidingAgain) {
  Bench once, often;
  BuildHeap(once);
  BuildHeap(often);

  once.Run(240);
  for (int i = 0; i < 240; ++i) {
    for (int j = 0; j < i % 3; ++j) often.Collide();
    often.Run(1);
  }

  EXPECT_EQ(often.state.positions, once.state.positions);
  EXPECT_EQ(often.Saved(), once.Saved());
}

TEST(BulletDeterminism, SavesTheImpulsesThatTheNextSolveStartsFrom) {
  Bench bench;
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  const EntityRow box = bench.Add(kUnitBox, {0, 0, 0.5});
  const std::string fresh = bench.Saved();

  bench.Run(10);
  const std::string loaded = bench.Saved();
  bench.Run(1);

  EXPECT_GT(loaded.size(), fresh.size());
  bench.Put(box, {{0, 0, 5}, Quaternion::Identity()});
  bench.Run(1);
  EXPECT_EQ(bench.Saved().size(), fresh.size()) << "the impulses of a contact that is gone are still there";
}

TEST(BulletDeterminism, ForgetsRemovedBodiesWhoseRowsAndIdsAreUsedAgain) {
  Bench bench;
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  const EntityRow first = bench.Add(kUnitBox, {0, 0, 0.5});
  bench.Add(kUnitBox, {3, 0, 0.5});
  bench.Run(5);

  bench.Remove(first);
  bench.AddAt(first, EntityId(Index(first), 2), Bench::Describe(kUnitBall), {{3, 0, 1.5}, Quaternion::Identity()});
  bench.Run(5);

  // The newcomer has the greatest id of the three, and comes last.
  ASSERT_EQ(bench.contacts.pairs.size(), 2u);
  EXPECT_EQ(bench.contacts.pairs[0].entity_b, EntityRow{2});
  EXPECT_EQ(bench.contacts.pairs[1].entity_a, EntityRow{2});
  EXPECT_EQ(bench.contacts.pairs[1].entity_b, first);
}

TEST(BulletFaults, StopOneWorldAndNoOther) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Bench good, put, spun;
  for (Bench* bench : {&good, &put, &spun}) BuildHeap(*bench);
  spun.Run(10);
  const EntityRow row = spun.moving[3];

  EXPECT_THROW(put.Put(row, {{kNan, 0, 0}, Quaternion::Identity()}), EngineFault);
  spun.state.angular_velocities(1, Index(row)) = kNan;
  EXPECT_THROW(spun.Run(1), EngineFault);

  good.Run(60);
  EXPECT_TRUE(good.state.positions.allFinite());
}

}  // namespace
}  // namespace genphys

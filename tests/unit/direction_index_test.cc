#include "core/src/shapes/direction_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <set>
#include <vector>

#include "genphys/narrow_phase.h"
#include "genphys/surface.h"
#include "support/random.h"

namespace genphys {
namespace {

using testing::Random;

TEST(DirectionIndex, VisitsAllThatAreNear) {
  constexpr double kDistance = 1.5e-3;
  Random random(2);
  DirectionIndex index;
  std::vector<Vector3> directions;
  // In crowds, and along the axes, where cells begin.
  for (uint32_t i = 0; i < 1000; ++i) {
    const Vector3 middle = i % 3 == 0 ? Vector3(Vector3::Unit(static_cast<int>(random.Below(3)))) : random.Direction();
    directions.push_back((middle + random.Vector(3e-3)).normalized());
    index.Add(directions.back(), i);
  }
  size_t near = 0, visited = 0;
  for (const Vector3& direction : directions) {
    std::set<uint32_t> found;
    index.VisitNear(direction, kDistance, [&](uint32_t number) { EXPECT_TRUE(found.insert(number).second); });
    visited += found.size();
    for (uint32_t i = 0; i < directions.size(); ++i) {
      if ((directions[i] - direction).norm() >= kDistance) continue;
      ++near;
      EXPECT_TRUE(found.contains(i));
    }
  }
  EXPECT_GT(near, 3 * directions.size());
  EXPECT_LT(visited, 20 * near);
}

// s, the least of three, in which a box finds where it meets a mesh of `count` triangles that lie anyhow around it.
double TimeInSoup(int count) {
  Random random(1);
  std::vector<Vector3> vertices;
  std::vector<uint32_t> indices;
  for (int i = 0; i < 3 * count; ++i) {
    vertices.push_back(random.Vector(1));
    indices.push_back(static_cast<uint32_t>(i));
  }
  const Shape soup = *MakeTriangleMesh(vertices, indices), box = Box{{0.5, 0.5, 0.5}};
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    Manifold manifold;
    const auto start = std::chrono::steady_clock::now();
    FindContacts(soup, {}, box, {}, 1e-3, manifold);
    EXPECT_GT(manifold.count, 0);
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

// Not to their square, which is 64 times as long.
TEST(DirectionIndex, LetsContactsTakeTimeInProportionToTriangles) {
  EXPECT_LT(TimeInSoup(24000), 24 * TimeInSoup(3000));
}

}  // namespace
}  // namespace genphys

// What stands.
#include <cmath>

#include "case.h"
#include "gauges.h"

namespace genphys::bench {
namespace {

Scene Towers() {
  constexpr int kCount = 40, kRow = 8, kHeight = 5;
  Scene scene{.has_ground = true, .friction = 0.5};
  for (int i = 0; i < kCount; ++i) {
    for (int j = 0; j < kHeight; ++j) {
      scene.Add(Box{{0.3, 0.3, 0.3}}, 1, At(10 * (i % kRow), 10 * (i / kRow), 0.3 + 0.605 * j));
    }
  }
  return scene;
}

// Every other row is moved by half a brick and begins and ends with half of one.
Scene Wall() {
  constexpr int kRows = 15, kBricks = 12;
  constexpr double kHalfLength = 0.25, kHalfHeight = 0.1, kJoint = 0.002;
  Scene scene{.has_ground = true, .friction = 0.6};
  const double pitch = 2 * kHalfLength + kJoint;
  for (int row = 0; row < kRows; ++row) {
    const double z = kHalfHeight + (2 * kHalfHeight + 0.001) * row;
    const bool is_moved = row % 2 == 1;
    for (int i = 0; i < kBricks + (is_moved ? 1 : 0); ++i) {
      const bool is_half = is_moved && (i == 0 || i == kBricks);
      const double half = is_half ? kHalfLength / 2 - kJoint / 4 : kHalfLength;
      double x = pitch * (i - (is_moved ? 0.5 : 0));
      if (is_half) x += (i == 0 ? 1 : -1) * pitch / 4;
      scene.Add(Box{{half, 0.12, kHalfHeight}}, is_half ? 1 : 2, At(x, 0, z));
    }
  }
  return scene;
}

Scene Dominoes() {
  constexpr int kCount = 40;
  Scene scene{.has_ground = true, .friction = 0.5};
  for (int i = 0; i < kCount; ++i) {
    const Vector3 spin = i == 0 ? Vector3(0, 2, 0) : Vector3::Zero();
    scene.Add(Box{{0.05, 0.25, 0.5}}, 1, At(0.5 * i, 0, 0.5), spin.cross(Vector3(0, 0, 0.5)), spin);
  }
  return scene;
}

Gauge Fallen() {
  return {"fallen, of all", [](const Simulation& simulation, const Scene& scene, double) {
            double count = 0;
            for (size_t i = 0; i < scene.bodies.size(); ++i) {
              const double up = (simulation.MotionOf(i).orientation * Vector3::UnitZ()).z();
              if (up < 0.9) ++count;
            }
            return count / static_cast<double>(scene.bodies.size());
          }};
}

Scene City() {
  constexpr int kRow = 30, kHouses = kRow * kRow, kThings = 400;
  constexpr double kBlock = 6;
  Scene scene{.has_ground = true, .friction = 0.5, .may_sleep = true};
  for (int i = 0; i < kHouses; ++i) scene.AddStatic(Box{{2, 2, 5}}, At(kBlock * (i % kRow), kBlock * (i / kRow), 5));
  for (int i = 0; i < kThings; ++i) {
    // 7 has no part in common with the row: they are spread over all streets.
    const int column = i * 7 % kRow, row = i / kRow * 2 + i % 2;
    scene.Add(Box{{0.3, 0.3, 0.3}}, 1, At(kBlock * (column + 0.5), kBlock * (row + 0.5), 0.3));
  }
  return scene;
}

}  // namespace

void AddStacks(std::vector<Case>& cases) {
  cases.push_back({.id = "towers",
                   .title = "40 towers of five boxes, far from each other",
                   .make = Towers,
                   .phases = {{"standing", 2, 1}},
                   .gauge = Drift()});
  cases.push_back({.id = "wall",
                   .title = "a wall of bricks, 15 rows high",
                   .make = Wall,
                   .phases = {{"standing", 2, 1}},
                   .gauge = Drift()});
  cases.push_back({.id = "dominoes",
                   .title = "40 dominoes, of which the first is pushed",
                   .make = Dominoes,
                   .phases = {{"falling", 0, 7}},
                   .gauge = Fallen()});
  cases.push_back({.id = "city",
                   .title = "400 boxes that nobody touches, among 900 houses; they may sleep",
                   .make = City,
                   .phases = {{"asleep", 4, 2}},
                   .gauge = Drift()});
}

}  // namespace genphys::bench

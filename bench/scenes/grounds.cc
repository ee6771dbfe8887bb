// Boxes and balls on hills.
#include <cmath>

#include "case.h"
#include "contenders/dice.h"
#include "genphys/surface.h"
#include "support/must.h"

namespace genphys::bench {
namespace {

constexpr uint32_t kPoints = 101;  // on each side
constexpr double kCell = 0.5;      // m

double Coordinate(uint32_t number) { return kCell * (number - (kPoints - 1) / 2.0); }
double Height(double x, double y) { return 0.4 * std::sin(0.7 * x) * std::cos(0.6 * y); }

Shape Field() {
  std::vector<double> heights;
  for (uint32_t row = 0; row < kPoints; ++row) {
    for (uint32_t column = 0; column < kPoints; ++column) {
      heights.push_back(Height(Coordinate(column), Coordinate(row)));
    }
  }
  return Must(MakeHeightfield(kPoints, kPoints, kCell, heights));
}

Shape Mesh() {
  std::vector<Vector3> corners;
  std::vector<uint32_t> triangles;
  for (uint32_t row = 0; row < kPoints; ++row) {
    for (uint32_t column = 0; column < kPoints; ++column) {
      const double x = Coordinate(column), y = Coordinate(row);
      corners.emplace_back(x, y, Height(x, y));
      if (row + 1 == kPoints || column + 1 == kPoints) continue;
      const uint32_t a = row * kPoints + column, b = a + kPoints;
      triangles.insert(triangles.end(), {a, a + 1, b + 1, a, b + 1, b});
    }
  }
  return Must(MakeTriangleMesh(corners, triangles));
}

Scene Hills(const Shape& ground) {
  constexpr int kCount = 120, kRow = 12;
  Scene scene{.friction = 0.5};
  scene.AddStatic(ground);
  Dice dice(kSeed);
  for (int i = 0; i < kCount; ++i) {
    const double x = 1.5 * (i % kRow - kRow / 2) + 0.2 * dice.Next(), y = 1.5 * (i / kRow - 5) + 0.2 * dice.Next();
    Pose pose = At(x, y, dice.Between(1.2, 2));
    pose.orientation = Turn(2 * dice.Next(), (dice.NextVector() + Vector3(0, 0, 1.2)).normalized());
    if (i % 2 == 0) {
      scene.Add(Box{{0.4, 0.3, 0.2}}, 1, pose);
    } else {
      scene.Add(Sphere{0.3}, 1, pose);
    }
  }
  return scene;
}

}  // namespace

void AddGrounds(std::vector<Case>& cases) {
  const std::vector<Phase> phases{{"falling", 0, 1.5}, {"rolling and lying", 4, 1}};
  cases.push_back({.id = "field",
                   .title = "60 boxes and 60 balls on a heightfield of 10,000 cells",
                   .make = [] { return Hills(Field()); },
                   .phases = phases,
                   .lowest = -2});
  cases.push_back({.id = "mesh",
                   .title = "the same on a mesh of 20,000 triangles",
                   .make = [] { return Hills(Mesh()); },
                   .phases = phases,
                   .lowest = -2});
}

}  // namespace genphys::bench

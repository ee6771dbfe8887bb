#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "bounce_watch.h"
#include "genphys/convex_hull.h"
#include "genphys/surface.h"
#include "problem.h"
#include "references.h"

namespace genphys::bench {
namespace {

constexpr double kDrop = 1;

struct Dropped {
  Shape shape;
  Quaternion orientation = Quaternion::Identity();
  double low = 0;  // height of its centre when it lies on the floor
};

Scene Drop(const Dropped& body, double restitution, bool on_mesh) {
  Scene scene{.has_ground = !on_mesh, .restitution = restitution};
  scene.Add(body.shape, 1, {{0, 0, body.low + kDrop}, body.orientation});
  if (on_mesh) {
    constexpr uint32_t kCells = 4;
    constexpr double kCell = 1.1;
    std::vector<Vector3> points;
    std::vector<uint32_t> indices;
    for (uint32_t row = 0; row <= kCells; ++row) {
      for (uint32_t column = 0; column <= kCells; ++column) {
        // It comes down inside a triangle.
        points.emplace_back((column - 2.3) * kCell, (row - 2.4) * kCell, 0);
        if (row == kCells || column == kCells) continue;
        const uint32_t at = row * (kCells + 1) + column;
        for (const uint32_t corner : {0u, 1u, kCells + 2, 0u, kCells + 2, kCells + 1}) indices.push_back(at + corner);
      }
    }
    scene.AddStatic(*MakeTriangleMesh(points, indices));
  }
  return scene;
}

std::string Percent(double restitution) { return std::to_string(std::lround(100 * restitution)); }

Problem Bounce(const std::string& name, const std::string& what, const Dropped& body, double restitution,
               double rest_time, bool on_mesh) {
  Problem problem{.id = "C5." + name + '.' + Percent(restitution),
                  .title = what + " falls 1 m, e = 0." + Percent(restitution).substr(0, 1),
                  .error = "height of the first four peaks, the worst, relative",
                  .scene = Drop(body, restitution, on_mesh)};
  problem.duration = std::round(rest_time * 30) / 30;
  problem.measure = [scene = problem.scene, body, restitution, rest_time](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    BounceWatch watch(body.low, kDrop, kGravity);
    run.StepTo(std::ceil(rest_time) + 2, [&] { watch.See(run[0], run.time()); });
    return {{"error", watch.PeakError(restitution)}, {"rest_time", std::abs(watch.unrest() / rest_time - 1)}};
  };
  return problem;
}

Problem Forever() {
  constexpr double kTime = 10;
  constexpr double kRadius = 0.1;
  Problem problem{.id = "C5.elastic",
                  .title = "ball falls 1 m, e = 1, for 10 s",
                  .error = "largest energy error, relative",
                  .scene = Drop({Sphere{kRadius}, Quaternion::Identity(), kRadius}, 1, false),
                  .duration = kTime};
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    const double rest = kGravity * kRadius;
    const double energy = run.Energy() - rest;
    double worst = 0;
    run.StepTo(kTime, [&] { worst = std::max(worst, std::abs((run.Energy() - rest) / energy - 1)); });
    return {{"error", worst}};
  };
  return problem;
}

Problem OnSlope() {
  constexpr double kTime = 0.8;
  constexpr double kRadius = 0.1;
  const Quaternion tilt = Turn(std::numbers::pi / 9, Vector3::UnitY());
  const Vector3 touch = tilt * Vector3(0, 0, kRadius);
  Problem problem{.id = "C5.slope",
                  .title = "ball falls 1 m on a tilted box, e = 0.8",
                  .error = "place after 0.8 s / 1 m",
                  .scene = {.restitution = 0.8},
                  .duration = kTime};
  problem.scene.AddStatic(Box{{2, 2, 0.5}}, {tilt * Vector3(0, 0, -0.5), tilt});
  problem.scene.Add(Sphere{kRadius}, 1, {.position = touch + Vector3(0, 0, kDrop)});
  problem.measure = [scene = problem.scene, touch](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    const Vector3 end = touch + Vector3(reference::kTiltedBounce[0], 0, reference::kTiltedBounce[1]);
    return {{"error", (run[1].position - end).norm() / kDrop}};
  };
  return problem;
}

Problem InTheAir() {
  constexpr double kTime = 0.5;
  Problem problem{.id = "C5.spheres",
                  .title = "two moving spheres meet aslant, e = 0.7",
                  .error = "places after 0.5 s, the worst / 1 m",
                  .scene = {.gravity = Vector3::Zero(), .restitution = 0.7},
                  .duration = kTime};
  problem.scene.Add(Sphere{0.1}, 1, At(0, 0, 0), {3, 0, 0});
  problem.scene.Add(Sphere{0.15}, 2, At(1, 0.1, 0.05), {-1, 0.2, 0});
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    const Vector3 momentum = run.Momentum();
    run.StepTo(kTime);
    const double first = (run[0].position - Vector3(reference::kFirstSphere.data())).norm();
    const double second = (run[1].position - Vector3(reference::kSecondSphere.data())).norm();
    return {{"error", std::max(first, second)}, {"momentum", (run.Momentum() - momentum).norm() / 3}};
  };
  return problem;
}

// Six corners above, six below.
ConvexHull Prism() {
  constexpr int kSides = 6;
  std::vector<Vector3> points;
  for (int i = 0; i < kSides; ++i) {
    const double angle = i * 2 * std::numbers::pi / kSides;
    for (const double z : {-0.1, 0.1}) points.emplace_back(0.15 * std::cos(angle), 0.15 * std::sin(angle), z);
  }
  return *MakeConvexHull(points);
}

}  // namespace

void AddBounces(std::vector<Problem>& problems) {
  constexpr std::array<double, 3> kRestitutions{0.5, 0.8, 0.9};
  const Quaternion lying = Turn(std::numbers::pi / 2, Vector3::UnitY());
  const Quaternion flat = Quaternion::Identity();
  struct Kind {
    std::string name;
    std::string what;
    Dropped body;
    bool on_mesh = false;
  };
  const std::array<Kind, 5> kinds{{{"ball", "ball", {Sphere{0.1}, flat, 0.1}},
                                   {"box", "box, flat,", {Box{{0.1, 0.1, 0.1}}, flat, 0.1}},
                                   {"capsule", "capsule, lying,", {Capsule{0.1, 0.15}, lying, 0.1}},
                                   {"hull", "six-sided prism, flat,", {Prism(), flat, 0.1}},
                                   {"mesh", "ball above a mesh", {Sphere{0.1}, flat, 0.1}, true}}};
  for (const Kind& kind : kinds) {
    for (size_t i = 0; i < kRestitutions.size(); ++i) {
      problems.push_back(
          Bounce(kind.name, kind.what, kind.body, kRestitutions[i], reference::kRestTimes[i], kind.on_mesh));
    }
  }
  problems.push_back(Forever());
  problems.push_back(OnSlope());
  problems.push_back(InTheAir());
}

}  // namespace genphys::bench

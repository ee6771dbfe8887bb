#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "contenders/dice.h"
#include "problem.h"

namespace genphys::bench {
namespace {

constexpr double kRadius = 0.1;

Problem HeadOn(const std::string& id, double restitution, const std::string& e) {
  constexpr double kSpeed = 4;
  constexpr double kMass = 3;
  constexpr double kTime = 1;
  Problem problem{.id = id,
                  .title = "1 kg runs into 3 kg, e = " + e,
                  .error = "speeds after it, the worst / 4 m/s",
                  .scene = {.gravity = Vector3::Zero(), .restitution = restitution},
                  .duration = kTime,
                  .first_order = false};
  problem.scene.Add(Sphere{kRadius}, 1, At(0, 0, 0), {kSpeed, 0, 0});
  problem.scene.Add(Sphere{kRadius}, kMass, At(1, 0, 0));
  problem.measure = [scene = problem.scene, restitution](const Lab& lab) -> std::vector<Quantity> {
    const double impulse = (1 + restitution) * kSpeed / (1 + 1 / kMass);
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    const double first = (run[0].velocity - Vector3(kSpeed - impulse, 0, 0)).norm();
    const double second = (run[1].velocity - Vector3(impulse / kMass, 0, 0)).norm();
    return {{"error", std::max(first, second) / kSpeed}, {"momentum", std::abs(run.Momentum().x() / kSpeed - 1)}};
  };
  return problem;
}

Problem Cradle(const std::string& id, double restitution, const std::string& e) {
  constexpr size_t kBalls = 5;
  constexpr double kGap = 1e-3;
  constexpr double kSpeed = 1;
  constexpr double kTime = 1;
  Problem problem{.id = id,
                  .title = "ball runs into a row of four with gaps of 1 mm, e = " + e,
                  .error = "speed of the last ball / 1 m/s",
                  .scene = {.gravity = Vector3::Zero(), .restitution = restitution},
                  .duration = kTime,
                  .first_order = false};
  for (size_t i = 0; i < kBalls; ++i) {
    const double x = i == 0 ? -0.5 : (2 * kRadius + kGap) * static_cast<double>(i);
    problem.scene.Add(Sphere{kRadius}, 1, At(x, 0, 0), {i == 0 ? kSpeed : 0, 0, 0});
  }
  problem.measure = [scene = problem.scene, restitution](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    const double last = kSpeed * std::pow((1 + restitution) / 2, kBalls - 1);
    return {{"error", std::abs(run[kBalls - 1].velocity.x() - last) / kSpeed},
            {"momentum", std::abs(run.Momentum().x() / kSpeed - 1)}};
  };
  return problem;
}

// 64 spheres on a grid that fly about, through each other's way.
Scene Gas(uint32_t seed) {
  constexpr int kRow = 4;
  constexpr double kSpacing = 0.5;
  Scene scene{.gravity = Vector3::Zero(), .restitution = 1};
  Dice dice(seed);
  for (int i = 0; i < kRow * kRow * kRow; ++i) {
    const Vector3 place(i % kRow, i / kRow % kRow, i / kRow / kRow);
    const Vector3 from_middle = kSpacing * (place - Vector3::Constant((kRow - 1) / 2.0));
    const Vector3 velocity = 2 * dice.NextVector() - from_middle;
    scene.Add(Sphere{kRadius}, 1, {.position = from_middle + 0.1 * dice.NextVector()}, velocity);
  }
  return scene;
}

void Enclose(Scene& scene) {
  constexpr double kHalf = 1.2;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      scene.AddStatic(Plane{side * Vector3::Unit(axis), -kHalf});
    }
  }
}

Problem Cloud(const std::string& id, bool enclosed) {
  constexpr double kTime = 3;
  static constexpr std::array<uint32_t, 3> kSeeds{1, 2, 3};
  Problem problem{.id = id,
                  .title = std::string("64 elastic spheres without friction") + (enclosed ? " in a box" : ""),
                  .error = "kinetic energy after 3 s, relative, the worst of three clouds",
                  .duration = kTime,
                  .first_order = false};
  const auto make = [enclosed](uint32_t seed) {
    Scene scene = Gas(seed);
    if (enclosed) Enclose(scene);
    return scene;
  };
  problem.scene = make(kSeeds.front());
  problem.measure = [make, enclosed](const Lab& lab) {
    std::vector<Quantity> worst{{"error"}, {"momentum"}, {"angular_momentum"}};
    if (enclosed) worst.resize(1);
    for (const uint32_t seed : kSeeds) {
      Run run = lab.Start(make(seed));
      const double energy = run.KineticEnergy();
      const Vector3 momentum = run.Momentum();
      const Vector3 angular = run.AngularMomentum();
      double all = 0, all_angular = 0;
      for (size_t i = 0; i < 64; ++i) {
        all += run[i].velocity.norm();
        all_angular += run[i].position.norm() * run[i].velocity.norm();
      }
      run.StepTo(kTime);
      worst[0].value = std::max(worst[0].value, std::abs(run.KineticEnergy() / energy - 1));
      if (enclosed) continue;
      worst[1].value = std::max(worst[1].value, (run.Momentum() - momentum).norm() / all);
      worst[2].value = std::max(worst[2].value, (run.AngularMomentum() - angular).norm() / all_angular);
    }
    return worst;
  };
  return problem;
}

constexpr std::array<double, 4> kSpeeds{3, 10, 50, 300};
constexpr std::array<double, 3> kRestitutions{0, 0.5, 1};
// Where it starts decides at which part of a step it hits.
constexpr std::array<double, 4> kStarts{-1, -1.013, -1.37, -2.71};

Scene Shot(double speed, double restitution, double start, bool plate_is_free) {
  constexpr double kBall = 0.05;
  Scene scene{.gravity = Vector3::Zero(), .restitution = restitution};
  scene.Add(Sphere{kBall}, 1, At(start, 0, 0), {speed, 0, 0});
  const Box plate{{0.01, 0.5, 0.5}};
  if (plate_is_free) {
    scene.Add(plate, 2, At(0, 0, 0));
  } else {
    scene.AddStatic(plate);
  }
  return scene;
}

Problem ThinWall() {
  Problem problem{.id = "S4",
                  .title = "ball of 5 cm at 3 to 300 m/s against a wall of 2 cm",
                  .error = "rebound against e v, over v, the worst",
                  .scene = Shot(10, 0.5, -1, false),
                  .duration = 0.5,
                  .first_order = false};
  problem.measure = [](const Lab& lab) -> std::vector<Quantity> {
    double worst = 0, through = 0;
    for (const double speed : kSpeeds) {
      for (const double e : kRestitutions) {
        for (const double start : kStarts) {
          Run run = lab.Start(Shot(speed, e, start, false));
          run.StepTo(std::ceil(-start / speed * 30 + 3) / 30);
          through += run[0].position.x() > 0 ? 1 : 0;
          worst = std::max(worst, std::abs(run[0].velocity.x() + e * speed) / speed);
        }
      }
    }
    return {{"error", worst}, {"passed", through}};
  };
  return problem;
}

Problem FreePlate() {
  constexpr double kPlate = 2;
  Problem problem{.id = "S4.free",
                  .title = "the same against a free plate of 2 kg",
                  .error = "speeds after it / v, the worst",
                  .scene = Shot(10, 0.5, -1, true),
                  .duration = 0.5,
                  .first_order = false};
  problem.measure = [](const Lab& lab) -> std::vector<Quantity> {
    double worst = 0, through = 0, momentum = 0;
    for (const double speed : kSpeeds) {
      for (const double e : kRestitutions) {
        for (const double start : kStarts) {
          Run run = lab.Start(Shot(speed, e, start, true));
          run.StepTo(std::ceil(-start / speed * 30 + 3) / 30);
          const double impulse = (1 + e) * speed / (1 + 1 / kPlate);
          through += run[0].position.x() > run[1].position.x() ? 1 : 0;
          worst = std::max({worst, std::abs(run[0].velocity.x() - speed + impulse) / speed,
                            std::abs(run[1].velocity.x() - impulse / kPlate) / speed});
          momentum = std::max(momentum, std::abs(run.Momentum().x() / speed - 1));
        }
      }
    }
    return {{"error", worst}, {"passed", through}, {"momentum", momentum}};
  };
  return problem;
}

}  // namespace

void AddCollisions(std::vector<Problem>& problems) {
  problems.push_back(HeadOn("C6.elastic", 1, "1"));
  problems.push_back(HeadOn("C6.half", 0.5, "0.5"));
  problems.push_back(Cradle("C7.elastic", 1, "1"));
  problems.push_back(Cradle("C7.90", 0.9, "0.9"));
  problems.push_back(Cloud("S13", false));
  problems.push_back(Cloud("S13.box", true));
  problems.push_back(ThinWall());
  problems.push_back(FreePlate());
}

}  // namespace genphys::bench

#include <algorithm>
#include <cmath>
#include <string>

#include "contenders/dice.h"
#include "trial.h"

namespace genphys::bench {
namespace {

Trial ThinWall(int speed) {
  Trial trial{.id = "S4." + std::to_string(speed),
              .title = "ball of 5 cm at " + std::to_string(speed) + " m/s against a wall of 2 cm, e = 0",
              .limits = {{"passed", 0}, {"rebound", 0.01}},
              .rates = {60, 240},
              .seeds = 10};
  trial.run = [speed](const Lab& lab, uint32_t seed) -> std::vector<Quantity> {
    Dice dice(seed);
    Scene scene{.gravity = Vector3::Zero()};
    const double start = -2 - dice.Next();
    scene.Add(Sphere{0.05}, 1, At(start, 0.2 * dice.Next(), 0), {static_cast<double>(speed), 0, 0});
    scene.AddStatic(Box{{0.01, 0.5, 0.5}});
    Run run = lab.Start(scene);
    run.StepTo(std::ceil(-start / speed * 60 + 6) / 60);
    return {{"passed", run[0].position.x() > 0 ? 1.0 : 0.0}, {"rebound", run[0].velocity.norm() / speed}};
  };
  return trial;
}

Trial Cloud(const std::string& id, double restitution, double friction, const std::string& how) {
  constexpr size_t kRow = 4;
  Trial trial{.id = id,
              .title = "64 spheres fly through each other's way for 3 s, " + how,
              .limits = {{"momentum", 1e-12}, {"angular_momentum", 1e-12}, {"energy_gain", 1e-3}},
              .rates = {240},
              .seeds = 5};
  if (restitution == 1) trial.limits.push_back({"energy_loss", 1e-3});
  trial.run = [restitution, friction](const Lab& lab, uint32_t seed) -> std::vector<Quantity> {
    Dice dice(seed);
    Scene scene{.gravity = Vector3::Zero(), .friction = friction, .restitution = restitution};
    for (size_t i = 0; i < kRow * kRow * kRow; ++i) {
      const Vector3 cell(static_cast<double>(i % kRow), static_cast<double>(i / kRow % kRow),
                         static_cast<double>(i / kRow / kRow));
      const Vector3 place = 0.5 * (cell - Vector3::Constant((kRow - 1) / 2.0));
      const Vector3 velocity = 2 * dice.NextVector() - place;
      scene.Add(Sphere{0.1}, 1, {.position = place + 0.1 * dice.NextVector()}, velocity);
    }
    Run run = lab.Start(scene);
    const double energy = run.KineticEnergy();
    const Vector3 momentum = run.Momentum(), angular = run.AngularMomentum();
    double all = 0, all_angular = 0;
    for (size_t i = 0; i < scene.bodies.size(); ++i) {
      all += run[i].velocity.norm();
      all_angular += run[i].position.norm() * run[i].velocity.norm();
    }
    run.StepTo(3);
    const double change = run.KineticEnergy() / energy - 1;
    return {{"momentum", (run.Momentum() - momentum).norm() / all},
            {"angular_momentum", (run.AngularMomentum() - angular).norm() / all_angular},
            {"energy_gain", std::max(change, 0.0)},
            {"energy_loss", std::max(-change, 0.0)}};
  };
  return trial;
}

}  // namespace

void AddHits(std::vector<Trial>& trials) {
  for (const int speed : {3, 10, 50, 300}) trials.push_back(ThinWall(speed));
  trials.push_back(Cloud("S13.elastic", 1, 0, "elastic and without friction"));
  trials.push_back(Cloud("S13.rough", 0.5, 0.5, "e = 0.5 and friction 0.5"));
}

}  // namespace genphys::bench

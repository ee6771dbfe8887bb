#include <algorithm>
#include <cmath>

#include "trial.h"

namespace genphys::bench {
namespace {

size_t AddSpinner(Scene& scene, const Vector3& moments, const Vector3& spin) {
  scene.gravity.setZero();
  const size_t body = scene.Add(Sphere{0.1}, 1, {}, Vector3::Zero(), spin);
  scene.bodies[body].rigid_body->inertia.tensor = moments.asDiagonal();
  return body;
}

// Largest kinetic energy over the first one, and largest error of the angular momentum over it.
std::vector<Quantity> Conserved(Run& run, double time) {
  const double energy = run.KineticEnergy();
  const Vector3 momentum = run.AngularMomentum();
  double gain = 0, change = 0, off = 0;
  run.StepTo(time, [&] {
    const double now = run.KineticEnergy() / energy - 1;
    gain = std::max(gain, now);
    change = std::max(change, std::abs(now));
    off = std::max(off, (run.AngularMomentum() - momentum).norm() / momentum.norm());
  });
  return {{"energy_gain", gain}, {"energy_change", change}, {"momentum", off}};
}

Trial Needle() {
  Trial trial{.id = "S5",
              .title = "needle, moments 1 and 1e-4, spinning at 1,000 rad/s, 10 s",
              .limits = {{"energy_gain", 1e-4}, {"momentum", 1e-3}},
              .rates = {60, 240, 1000}};
  trial.run = [](const Lab& lab, uint32_t) {
    Scene scene;
    AddSpinner(scene, {1, 1, 1e-4}, {1, 0, 1000});
    Run run = lab.Start(scene);
    return Conserved(run, 10);
  };
  return trial;
}

Trial TurningOver() {
  constexpr int kFlips = 7;
  Trial trial{.id = "S6",
              .title = "body that turns over 7 times in 60 s",
              .limits = {{"flips_missed", 0}, {"energy_change", 1e-3}},
              .rates = {60, 240, 1000}};
  trial.run = [](const Lab& lab, uint32_t) -> std::vector<Quantity> {
    Scene scene;
    AddSpinner(scene, {2, 3, 4}, {0, 5, 0.01});
    Run run = lab.Start(scene);
    const auto spin = [&run] { return (run[0].orientation.conjugate() * run[0].spin).y(); };
    const double energy = run.KineticEnergy();
    int flips = 0;
    double before = spin(), change = 0;
    run.StepTo(60, [&] {
      const double now = spin();
      flips += before * now < 0 ? 1 : 0;
      before = now;
      change = std::max(change, std::abs(run.KineticEnergy() / energy - 1));
    });
    return {{"flips_missed", static_cast<double>(std::abs(flips - kFlips))}, {"energy_change", change}};
  };
  return trial;
}

Trial LongTumble() {
  Trial trial{.id = "S12",
              .title = "tumbling body for 100,000 steps",
              .limits = {{"energy_change", 1e-4}, {"momentum", 1e-9}},
              .rates = {240}};
  trial.run = [](const Lab& lab, uint32_t) {
    Scene scene;
    AddSpinner(scene, {2, 3, 4}, {0, 2, 1});
    Run run = lab.Start(scene);
    return Conserved(run, 100'000 / 240.0);
  };
  return trial;
}

}  // namespace

void AddSpins(std::vector<Trial>& trials) {
  trials.push_back(Needle());
  trials.push_back(TurningOver());
  trials.push_back(LongTumble());
}

}  // namespace genphys::bench

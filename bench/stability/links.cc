#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "trial.h"

namespace genphys::bench {
namespace {

// Ten links of 0.1 kg and 0.1 m on balls, and 100 kg at the end, in a straight line `angle` from hanging.
Trial HeavyChain(const std::string& id, const std::string& how, double angle) {
  static constexpr int kLinks = 10;
  static constexpr double kLink = 0.1;
  static constexpr double kChain = (kLinks + 1) * kLink;
  Trial trial{.id = id,
              .title = "ten links with a thousandfold mass at the end, " + how + ", 5 s",
              .limits = {{"gap", 1e-3}, {"energy_gain", 1e-2}}};
  trial.run = [angle](const Lab& lab, uint32_t) -> std::vector<Quantity> {
    Scene scene;
    const Quaternion turn = Turn(-angle, Vector3::UnitY());
    const Vector3 along = turn * -Vector3::UnitZ();
    std::optional<size_t> above;
    for (int i = 0; i < kLinks; ++i) {
      const size_t link = scene.Add(Capsule{0.01, kLink / 2 - 0.01}, 0.1, {along * kLink * (i + 0.5), turn});
      scene.Join(BallJoint{}, above, link, along * kLink * i);
      above = link;
    }
    scene.Join(BallJoint{}, above, scene.Add(Sphere{0.08}, 100, {along * kChain, turn}), along * kLink * kLinks);
    Run run = lab.Start(scene);
    const double energy = run.Energy();
    double gap = 0, gain = 0;
    run.StepTo(5, [&] {
      gap = std::max(gap, run.JointGap() / kChain);
      gain = std::max(gain, (run.Energy() - energy) / (100 * kGravity * kChain));
    });
    return {{"gap", gap}, {"energy_gain", gain}};
  };
  return trial;
}

// Its period is far shorter than most of these steps.
Trial StiffSpring() {
  constexpr double kStiffness = 1e6;
  constexpr double kStart = 0.1;
  constexpr int kSteps = 1000;
  Trial trial{.id = "S10",
              .title = "1 kg on a spring of 1e6 N/m, pulled by 0.1 m, 1,000 steps",
              .limits = {{"amplitude", 1.01}},
              .rates = {10, 60, 240, 1000, 10'000},
              .needs_springs = true};
  trial.run = [](const Lab& lab, uint32_t) -> std::vector<Quantity> {
    Scene scene;
    scene.gravity.setZero();
    const size_t body = scene.Add(Sphere{0.1}, 1, At(0, 0, 0));
    JointAxis axis;
    axis.spring = Spring{.stiffness = kStiffness, .rest = -kStart};
    scene.Join(SliderJoint{axis}, std::nullopt, body, Vector3::Zero());
    Run run = lab.Start(scene);
    double amplitude = 0;
    run.StepTo(kSteps * lab.step_size(),
               [&] { amplitude = std::max(amplitude, std::abs(run[0].position.z() + kStart) / kStart); });
    return {{"amplitude", amplitude}};
  };
  return trial;
}

Trial LongSwing() {
  Trial trial{.id = "S11",
              .title = "rod that swings from its end for 100,000 steps",
              .limits = {{"energy_change", 1e-2}, {"gap", 1e-5}},
              .rates = {240}};
  trial.run = [](const Lab& lab, uint32_t) -> std::vector<Quantity> {
    Scene scene;
    const size_t rod = scene.Add(Box{{0.5, 0.025, 0.025}}, 1, At(0.5, 0, 0));
    scene.Join(HingeJoint{}, std::nullopt, rod, Vector3::Zero(), Vector3::UnitY());
    Run run = lab.Start(scene);
    double change = 0, gap = 0;
    run.StepTo(100'000 / 240.0, [&] {
      change = std::max(change, std::abs(run.Energy()) / (kGravity * 0.5));
      gap = std::max(gap, run.JointGap());
    });
    return {{"energy_change", change}, {"gap", gap}};
  };
  return trial;
}

}  // namespace

void AddLinks(std::vector<Trial>& trials) {
  trials.push_back(HeavyChain("S3.hanging", "hanging", 0));
  trials.push_back(HeavyChain("S3.swinging", "from 30 degrees", std::numbers::pi / 6));
  trials.push_back(StiffSpring());
  trials.push_back(LongSwing());
}

}  // namespace genphys::bench

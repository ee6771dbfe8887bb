#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "contenders/dice.h"
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

// The same of what dice choose: links, masses, lengths, ways to lean and to join.
Trial AnyChain() {
  constexpr double kTime = 5;
  Trial trial{.id = "S3.any",
              .title = "any chain with a heavy mass at the end, leaning by up to 60 degrees, 5 s",
              .limits = {{"gap", 1e-3}, {"energy_gain", 1e-2}},
              .seeds = 30};
  trial.run = [](const Lab& lab, uint32_t seed) -> std::vector<Quantity> {
    Dice dice(seed);
    const int links = static_cast<int>(dice.Between(3, 20));
    const double length = dice.LogBetween(0.03, 0.5), mass = dice.LogBetween(0.01, 1);
    const double ratio = dice.LogBetween(10, 1e4), thickness = dice.Between(0.02, 0.2) * length;
    const Quaternion turn = Turn(dice.Between(0, 1.05), Vector3::UnitY());
    const Vector3 along = turn * -Vector3::UnitZ();
    const double chain = (links + 1) * length;
    const bool is_hinged = dice.Next() > 0;
    const auto join = [&](Scene& scene, std::optional<size_t> a, size_t b, const Vector3& place) {
      if (is_hinged) {
        scene.Join(HingeJoint{}, a, b, place, Vector3::UnitY());
      } else {
        scene.Join(BallJoint{}, a, b, place);
      }
    };
    Scene scene;
    std::optional<size_t> above;
    for (int i = 0; i < links; ++i) {
      const Capsule shape{thickness / 2, (length - thickness) / 2};
      const size_t link = scene.Add(shape, mass, {along * length * (i + 0.5), turn});
      join(scene, above, link, along * length * i);
      above = link;
    }
    join(scene, above, scene.Add(Sphere{length * 0.8}, mass * ratio, {along * chain, turn}), along * length * links);
    Run run = lab.Start(scene);
    const double energy = run.Energy(), scale = mass * (links + ratio) * kGravity * chain;
    double gap = 0, gain = 0;
    run.StepTo(kTime, [&] {
      gap = std::max(gap, run.JointGap() / chain);
      gain = std::max(gain, (run.Energy() - energy) / scale);
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
  trials.push_back(AnyChain());
  trials.push_back(StiffSpring());
  trials.push_back(LongSwing());
}

}  // namespace genphys::bench

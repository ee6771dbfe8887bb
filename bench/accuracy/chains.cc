#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "problem.h"

namespace genphys::bench {
namespace {

constexpr int kLinks = 10;
constexpr double kLinkLength = 0.1;
constexpr double kChainLength = (kLinks + 1) * kLinkLength;

// Ten links of 0.1 kg and 0.1 m on balls, and 100 kg at the end, in a straight line `angle` from hanging.
Scene Chain(double angle) {
  Scene scene;
  const Quaternion turn = Turn(-angle, Vector3::UnitY());
  const Vector3 along = turn * -Vector3::UnitZ();
  std::optional<size_t> above;
  for (int i = 0; i < kLinks; ++i) {
    const size_t link = scene.Add(Capsule{0.01, kLinkLength / 2 - 0.01}, 0.1, {along * kLinkLength * (i + 0.5), turn});
    scene.Join(BallJoint{}, above, link, along * kLinkLength * i);
    above = link;
  }
  const size_t ball = scene.Add(Sphere{0.08}, 100, {along * kChainLength, turn});
  scene.Join(BallJoint{}, above, ball, along * kLinkLength * kLinks);
  return scene;
}

Problem HeavyEnd(const std::string& id, const std::string& how, double angle, double time) {
  Problem problem{.id = id,
                  .title = "ten links with a thousandfold mass at the end, " + how,
                  .error = "widest joint / 1.1 m",
                  .scene = Chain(angle),
                  .duration = time};
  problem.measure = [scene = problem.scene, time](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    const double energy = run.Energy();
    double gap = 0, stretch = 0;
    run.StepTo(time, [&] {
      gap = std::max(gap, run.JointGap());
      stretch = std::max(stretch, run[kLinks].position.norm() / kChainLength - 1);
    });
    return {{"error", gap / kChainLength},
            {"stretch", stretch},
            {"energy", std::abs(run.Energy() - energy) / (100 * kGravity * kChainLength)}};
  };
  return problem;
}

}  // namespace

void AddChains(std::vector<Problem>& problems) {
  problems.push_back(HeavyEnd("B11.hanging", "hanging", 0, 5));
  problems.push_back(HeavyEnd("B11.swinging", "from 30 degrees", std::numbers::pi / 6, 2));
}

}  // namespace genphys::bench

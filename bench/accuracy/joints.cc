#include <algorithm>
#include <cmath>
#include <numbers>

#include "problem.h"
#include "references.h"

namespace genphys::bench {
namespace {

constexpr double kRodLength = 1;

size_t AddRod(Scene& scene, double x) { return scene.Add(Box{{kRodLength / 2, 0.025, 0.025}}, 1, At(x, 0, 0)); }

Vector3 InPlane(const std::array<double, 2>& xz) { return {xz[0], 0, xz[1]}; }

// A rod that is hung at its end and let go when horizontal.
Scene Pendulum() {
  Scene scene;
  scene.Join(HingeJoint{}, std::nullopt, AddRod(scene, kRodLength / 2), Vector3::Zero(), Vector3::UnitY());
  return scene;
}

Problem SwingingRod() {
  constexpr double kTime = 5;
  Problem problem{
      .id = "B1", .title = "rod hung at its end, from horizontal", .error = "place of its middle at 5 s / 0.5 m"};
  problem.scene = Pendulum();
  problem.duration = kTime;
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    double gap = 0;
    const double energy = run.Energy();
    run.StepTo(kTime, [&] { gap = std::max(gap, run.JointGap()); });
    const double meters = (run[0].position - InPlane(reference::kPendulum)).norm();
    return {{"error", meters / (kRodLength / 2)},
            {"meters", meters},
            {"gap", gap},
            {"energy", std::abs(run.Energy() - energy) / (kGravity * kRodLength / 2)}};
  };
  return problem;
}

Problem LongSwing() {
  constexpr int kSteps = 100'000;
  constexpr int kRate = 240;
  Problem problem{.id = "B1.long",
                  .title = "the same for 100,000 steps",
                  .error = "largest energy error / (m g 0.5 m)",
                  .duration = 10,
                  .rates = {kRate}};
  problem.scene = Pendulum();
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    double worst = 0, gap = 0;
    const double energy = run.Energy();
    run.StepTo(double{kSteps} / kRate, [&] {
      worst = std::max(worst, std::abs(run.Energy() - energy));
      gap = std::max(gap, run.JointGap());
    });
    return {{"error", worst / (kGravity * kRodLength / 2)}, {"gap", gap}};
  };
  return problem;
}

Problem DoublePendulum() {
  constexpr double kTime = 2;
  Problem problem{
      .id = "B3", .title = "two rods in a row, from horizontal", .error = "place of the second at 2 s / 1 m"};
  const size_t upper = AddRod(problem.scene, kRodLength / 2);
  const size_t lower = AddRod(problem.scene, kRodLength * 1.5);
  problem.scene.Join(HingeJoint{}, std::nullopt, upper, Vector3::Zero(), Vector3::UnitY());
  problem.scene.Join(HingeJoint{}, upper, lower, {kRodLength, 0, 0}, Vector3::UnitY());
  problem.duration = kTime;
  problem.measure = [scene = problem.scene, lower](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    double gap = 0;
    const double energy = run.Energy();
    run.StepTo(kTime, [&] { gap = std::max(gap, run.JointGap()); });
    const double meters = (run[lower].position - InPlane(reference::kDoublePendulum)).norm();
    return {{"error", meters / kRodLength},
            {"meters", meters},
            {"gap", gap},
            {"energy", std::abs(run.Energy() - energy) / (kGravity * kRodLength)}};
  };
  return problem;
}

Problem HeavyTop() {
  constexpr double kTime = 2;
  constexpr double kLength = 0.3;
  constexpr double kSpin = 50;
  Problem problem{
      .id = "B4", .title = "fast top on its tip, tilted by 60 degrees", .error = "place of its centre at 2 s / 0.3 m"};
  const Quaternion tilt = Turn(std::numbers::pi / 3, Vector3::UnitY());
  const Vector3 axis = tilt * Vector3::UnitZ();
  const Pose pose{kLength * axis, tilt};
  const size_t top = problem.scene.Add(Cylinder{0.2, 0.05}, 1, pose, Vector3::Zero(), kSpin * axis);
  problem.scene.Join(BallJoint{}, std::nullopt, top, Vector3::Zero());
  problem.duration = kTime;
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    double gap = 0;
    const double energy = run.Energy();
    run.StepTo(kTime, [&] { gap = std::max(gap, run.JointGap()); });
    const double meters = (run[0].position - Vector3(reference::kHeavyTop.data())).norm();
    return {{"error", meters / kLength},
            {"meters", meters},
            {"gap", gap},
            {"energy", std::abs(run.Energy() - energy) / (kGravity * kLength)}};
  };
  return problem;
}

// Set free at the side of its swing that shows an error of velocity most.
Problem ReleasedRod() {
  constexpr double kRelease = 0.5;
  constexpr double kTime = 1;
  Problem problem{.id = "D3", .title = "the rod set free at 0.5 s", .error = "place of its middle at 1 s / 0.5 m"};
  problem.scene = Pendulum();
  problem.duration = kRelease;
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kRelease);
    run.simulation().Release(0);
    run.StepTo(kTime);
    const double meters = (run[0].position - InPlane(reference::kReleasedPendulum)).norm();
    return {{"error", meters / (kRodLength / 2)}, {"meters", meters}};
  };
  return problem;
}

}  // namespace

void AddJoints(std::vector<Problem>& problems) {
  problems.push_back(SwingingRod());
  problems.push_back(LongSwing());
  problems.push_back(DoublePendulum());
  problems.push_back(HeavyTop());
  problems.push_back(ReleasedRod());
}

}  // namespace genphys::bench

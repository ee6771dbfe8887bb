#include <algorithm>
#include <cmath>

#include "problem.h"
#include "references.h"

namespace genphys::bench {
namespace {

double AngleBetween(const Quaternion& a, const Quaternion& b) {
  const Quaternion turn = a * b.conjugate();
  return 2 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
}

Problem FreeFall() {
  constexpr double kTime = 2;
  constexpr double kFallen = kGravity * kTime * kTime / 2;
  constexpr double kHeight = 100;
  Problem problem{.id = "A1", .title = "free fall of 2 s", .error = "height / 19.62 m", .duration = kTime};
  problem.scene.Add(Sphere{0.1}, 1, At(0, 0, kHeight));
  problem.euler_error = kGravity * kTime / 2 / kFallen;
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    return {{"error", std::abs(run[0].position.z() - (kHeight - kFallen)) / kFallen},
            {"speed", std::abs(run[0].velocity.z() + kGravity * kTime) / kFallen}};
  };
  return problem;
}

Problem SpinningProjectile() {
  constexpr double kTime = 2;
  constexpr double kRange = 20;
  constexpr double kSpin = 5;
  const Vector3 start(0, 0, 1);
  const Vector3 velocity(10, 0, 10);
  Problem problem{.id = "A2",
                  .title = "projectile of 2 s that turns by 10 rad about a principal axis",
                  .error = "place / 20 m, or angle / 10 rad if that is worse",
                  .duration = kTime};
  problem.scene.Add(Box{{0.2, 0.15, 0.1}}, 1, {.position = start}, velocity, {0, 0, kSpin});
  problem.euler_error = kGravity * kTime / 2 / kRange;
  problem.measure = [=, scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    const Vector3 end = start + velocity * kTime + scene.gravity * kTime * kTime / 2;
    const double place = (run[0].position - end).norm() / kRange;
    const double angle = AngleBetween(run[0].orientation, Turn(kSpin * kTime, Vector3::UnitZ())) / (kSpin * kTime);
    return {{"error", std::max(place, angle)}, {"place", place}, {"angle", angle}};
  };
  return problem;
}

// 12 kg with principal moments 2, 3 and 4.
size_t AddTop(Scene& scene, const Vector3& spin) {
  const Vector3 half_extents = Vector3(std::sqrt(2.5), std::sqrt(1.5), std::sqrt(0.5)) / 2;
  return scene.Add(Box{half_extents}, 12, {}, Vector3::Zero(), spin);
}

double Relative(const Vector3& now, const Vector3& before) { return (now - before).norm() / before.norm(); }

Problem AsymmetricTop() {
  constexpr double kTime = 10;
  Problem problem{
      .id = "A5", .title = "tumbling body, moments 2, 3, 4", .error = "orientation, rad", .duration = kTime};
  problem.scene.gravity.setZero();
  AddTop(problem.scene, {0, 2, 1});
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    const auto& q = reference::kTopOrientation;
    Run run = lab.Start(scene);
    const double energy = run.Energy();
    const Vector3 momentum = run.AngularMomentum();
    run.StepTo(kTime);
    return {{"error", AngleBetween(run[0].orientation, {q[0], q[1], q[2], q[3]})},
            {"energy", std::abs(run.Energy() / energy - 1)},
            {"momentum", Relative(run.AngularMomentum(), momentum)}};
  };
  return problem;
}

Problem LongTumble() {
  constexpr int kSteps = 100'000;
  constexpr int kRate = 240;
  Problem problem{.id = "A5.long",
                  .title = "the same for 100,000 steps",
                  .error = "largest energy error, relative",
                  .duration = 10,
                  .rates = {kRate}};
  problem.scene.gravity.setZero();
  AddTop(problem.scene, {0, 2, 1});
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    const double energy = run.Energy();
    const Vector3 momentum = run.AngularMomentum();
    double worst = 0, worst_momentum = 0;
    run.StepTo(double{kSteps} / kRate, [&] {
      worst = std::max(worst, std::abs(run.Energy() / energy - 1));
      worst_momentum = std::max(worst_momentum, Relative(run.AngularMomentum(), momentum));
    });
    return {{"error", worst}, {"momentum", worst_momentum}};
  };
  return problem;
}

// It spins about its middle axis and turns over every now and then.
Problem Dzhanibekov() {
  constexpr double kTime = 60;
  Problem problem{.id = "A5dz",
                  .title = "body that turns over, 7 times in 60 s",
                  .error = "time of the first turn, relative",
                  .duration = 10};
  problem.scene.gravity.setZero();
  AddTop(problem.scene, {0, 5, 0.01});
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    constexpr int kFlips = 7;
    constexpr double kFirst = reference::kFlipPeriod / 2;
    Run run = lab.Start(scene);
    const auto spin = [&run] { return (run[0].orientation.conjugate() * run[0].spin).y(); };
    const double energy = run.Energy();
    int flips = 0;
    double first = 0, before = spin(), time_before = 0;
    run.StepTo(kTime, [&] {
      const double now = spin();
      if (before * now < 0 && ++flips == 1) {
        first = time_before + (run.time() - time_before) * before / (before - now);
      }
      before = now;
      time_before = run.time();
    });
    return {{"error", std::abs(first / kFirst - 1)},
            {"flips_missed", static_cast<double>(std::abs(flips - kFlips))},
            {"energy", std::abs(run.Energy() / energy - 1)}};
  };
  return problem;
}

Problem ConstantTorque() {
  constexpr double kTime = 2;
  static constexpr double kTorque = 3;
  constexpr double kAngle = 3;
  Problem problem{
      .id = "A7", .title = "constant torque, from rest to 3 rad in 2 s", .error = "angle / 3 rad", .duration = kTime};
  problem.scene.gravity.setZero();
  // 12 kg with a moment of 2 about z.
  problem.scene.Add(Box{{0.5, 0.5, 0.25}}, 12, {});
  problem.euler_error = kTorque / 2 * kTime / 2 / kAngle;
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.simulation().Hold(0, Vector3::Zero(), kTorque * Vector3::UnitZ());
    run.StepTo(kTime);
    return {{"error", AngleBetween(run[0].orientation, Turn(kAngle, Vector3::UnitZ())) / kAngle},
            {"spin", std::abs(run[0].spin.z() - kAngle) / kAngle}};
  };
  return problem;
}

Problem WithRandomSteps(Problem problem) {
  problem.id += ".random";
  problem.title += ", steps of random size";
  problem.plan = StepPlan::kRandom;
  problem.euler_error.reset();
  return problem;
}

}  // namespace

void AddFreeBodies(std::vector<Problem>& problems) {
  for (const Problem& exact : {FreeFall(), SpinningProjectile(), ConstantTorque()}) {
    problems.push_back(exact);
    problems.push_back(WithRandomSteps(exact));
  }
  problems.push_back(AsymmetricTop());
  problems.push_back(LongTumble());
  problems.push_back(Dzhanibekov());
}

}  // namespace genphys::bench

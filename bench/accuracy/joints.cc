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

// Started as it goes on: its tip draws a circle, and the axis never nods.
Problem SteadyTop() {
  constexpr double kTime = 2;
  static constexpr double kLength = 0.3;
  constexpr double kSpin = 50;
  const double lean = std::numbers::pi / 3;
  Problem problem{
      .id = "B4.steady", .title = "the same top in steady precession", .error = "place of its centre at 2 s / 0.3 m"};
  const Quaternion tilt = Turn(lean, Vector3::UnitY());
  const Vector3 axis = tilt * Vector3::UnitZ();
  // The part of the spin that is along the axis comes to kSpin with that of the precession.
  const Vector3 spin =
      reference::kPrecession * Vector3::UnitZ() + (kSpin - reference::kPrecession * std::cos(lean)) * axis;
  const size_t top =
      problem.scene.Add(Cylinder{0.2, 0.05}, 1, {kLength * axis, tilt}, spin.cross(kLength * axis), spin);
  problem.scene.Join(BallJoint{}, std::nullopt, top, Vector3::Zero());
  problem.duration = kTime;
  problem.measure = [scene = problem.scene, axis](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    double nod = 0;
    run.StepTo(kTime, [&] { nod = std::max(nod, std::abs(run[0].position.z() / kLength - axis.z())); });
    const Vector3 end = Turn(reference::kPrecession * kTime, Vector3::UnitZ()) * (kLength * axis);
    return {{"error", (run[0].position - end).norm() / kLength}, {"nod", nod}};
  };
  return problem;
}

// A thin rod in the plane of x and z: only its moment about y counts.
size_t AddThinRod(Scene& scene, const Vector3& from, const Vector3& to, const Vector3& velocity, double spin) {
  const double length = (to - from).norm();
  const Pose pose{(from + to) / 2, Quaternion::FromTwoVectors(Vector3::UnitX(), to - from)};
  const size_t rod = scene.Add(Box{{length / 2, 0.005, 0.005}}, 1, pose, velocity, {0, spin, 0});
  const double moment = length * length / 12;
  scene.bodies[rod].rigid_body->inertia.tensor = Vector3(moment, moment, moment).asDiagonal();
  return rod;
}

Problem SliderCrank() {
  constexpr double kTime = 1;
  constexpr double kCrank = 0.1, kRod = 0.3, kRate = 20;
  constexpr double kAngle = std::numbers::pi / 3;
  Problem problem{
      .id = "B5", .title = "crank, rod and slider, a closed loop", .error = "place of the slider at 1 s / 0.1 m"};
  problem.scene.gravity.setZero();
  const double lean = std::asin(kCrank * std::sin(kAngle) / kRod);
  const double lean_rate = kRate * kCrank * std::cos(kAngle) / (kRod * std::cos(lean));
  const Vector3 pin = kCrank * Vector3(std::cos(kAngle), 0, std::sin(kAngle));
  const Vector3 end(pin.x() + kRod * std::cos(lean), 0, 0);
  const Vector3 pin_velocity = kRate * kCrank * Vector3(-std::sin(kAngle), 0, std::cos(kAngle));
  const Vector3 end_velocity(pin_velocity.x() - kRod * std::sin(lean) * lean_rate, 0, 0);
  Scene& scene = problem.scene;
  // About y a turn from x towards z is negative.
  const size_t crank = AddThinRod(scene, Vector3::Zero(), pin, pin_velocity / 2, -kRate);
  const size_t rod = AddThinRod(scene, pin, end, (pin_velocity + end_velocity) / 2, lean_rate);
  const size_t slider = scene.Add(Box{{0.02, 0.02, 0.02}}, 1, {.position = end}, end_velocity);
  scene.Join(HingeJoint{}, std::nullopt, crank, Vector3::Zero(), Vector3::UnitY());
  scene.Join(HingeJoint{}, crank, rod, pin, Vector3::UnitY());
  scene.Join(HingeJoint{}, rod, slider, end, Vector3::UnitY());
  scene.Join(SliderJoint{}, std::nullopt, slider, end, Vector3::UnitX());
  problem.duration = kTime;
  problem.measure = [scene, slider](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    const double energy = run.Energy();
    double gap = 0;
    run.StepTo(kTime, [&] { gap = std::max(gap, run.JointGap()); });
    const Vector3 wanted(reference::kSliderCrank, 0, 0);
    return {{"error", (run[slider].position - wanted).norm() / kCrank},
            {"gap", gap},
            {"energy", std::abs(run.Energy() / energy - 1)}};
  };
  return problem;
}

Problem SlideDown() {
  constexpr double kTime = 2;
  static constexpr double kPath = kGravity / 2 * kTime * kTime / 2;
  Problem problem{.id = "B9", .title = "body on a slider, 30 degrees steep", .error = "place after 2 s / 9.81 m"};
  const Vector3 down(std::cos(std::numbers::pi / 6), 0, -0.5);
  const size_t body = problem.scene.Add(Box{{0.1, 0.1, 0.1}}, 1, At(0, 0, 0));
  problem.scene.Join(SliderJoint{}, std::nullopt, body, Vector3::Zero(), down);
  problem.duration = kTime;
  problem.euler_error = 1 / kTime;
  problem.measure = [scene = problem.scene, down](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    return {{"error", (run[0].position - kPath * down).norm() / kPath}};
  };
  return problem;
}

// A body on a slider, of which a spring holds one end.
Scene OnSpring(double stiffness, double damping, double start) {
  Scene scene;
  scene.gravity.setZero();
  JointAxis axis;
  axis.spring = Spring{.stiffness = stiffness, .damping = damping, .rest = -start};
  scene.Join(SliderJoint{axis}, std::nullopt, scene.Add(Sphere{0.1}, 1, At(0, 0, start)), {0, 0, start});
  return scene;
}

Problem Sprung() {
  constexpr double kStart = 0.1;
  constexpr double kTime = 1;
  Problem problem{.id = "A3",
                  .title = "1 kg on a spring of 1,000 N/m with little damping",
                  .error = "place after 1 s / 0.1 m",
                  .scene = OnSpring(1000, 2, kStart),
                  .duration = kTime,
                  .needs_springs = true};
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    return {{"error", std::abs(run[0].position.z() - reference::kSprung) / kStart}};
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
  problems.push_back(Sprung());
  problems.push_back(SwingingRod());
  problems.push_back(LongSwing());
  problems.push_back(DoublePendulum());
  problems.push_back(HeavyTop());
  problems.push_back(SteadyTop());
  problems.push_back(SliderCrank());
  problems.push_back(SlideDown());
  problems.push_back(ReleasedRod());
}

}  // namespace genphys::bench

// The other problems have one scene each, to which a stepper might happen to be kind: here dice choose the numbers.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "bounce_watch.h"
#include "contenders/dice.h"
#include "problem.h"

namespace genphys::bench {
namespace {

constexpr uint32_t kSeeds = 20;

using Throw = std::function<std::vector<Quantity>(const Lab&, Dice&)>;

// The worst of all seeds, quantity by quantity. What is timed is the scene of another problem.
Problem Any(const std::string& id, const std::string& title, const std::string& error, const Throw& one) {
  Problem problem{.id = id, .title = title + ", 20 times at random", .error = error + ", the worst"};
  problem.measure = [one](const Lab& lab) {
    std::vector<Quantity> worst;
    for (uint32_t seed = 1; seed <= kSeeds; ++seed) {
      Dice dice(seed);
      const std::vector<Quantity> each = one(lab, dice);
      if (worst.empty()) worst = each;
      for (size_t i = 0; i < each.size(); ++i) worst[i].value = std::max(worst[i].value, each[i].value);
    }
    return worst;
  };
  return problem;
}

double WholeSteps(const Lab& lab, double time) { return std::ceil(time / lab.step_size() - 1e-9) * lab.step_size(); }

Vector3 Heading(Dice& dice) {
  const double angle = dice.Between(0, 2 * std::numbers::pi);
  return {std::cos(angle), std::sin(angle), 0};
}

// Flat, so that it does not tip over.
Vector3 AnyBlock(Dice& dice) {
  const double x = dice.LogBetween(0.05, 0.5), y = dice.LogBetween(0.05, 0.5);
  return {x, y, 0.25 * std::min(x, y)};
}

std::vector<Quantity> OnSlope(const Lab& lab, Dice& dice, double steeper) {
  constexpr double kTime = 2;
  const double friction = dice.Between(0.1, 1.2), gravity = dice.Between(3, 20);
  const double angle = std::atan(friction * (1 + steeper));
  const Vector3 down = Heading(dice);
  const Vector3 half = AnyBlock(dice);
  Scene scene{.gravity = gravity * (std::sin(angle) * down - std::cos(angle) * Vector3::UnitZ()),
              .has_ground = true,
              .friction = friction};
  scene.Add(Box{half}, dice.LogBetween(0.01, 100), {{0, 0, half.z()}, Turn(dice.Next(), Vector3::UnitZ())});
  Run run = lab.Start(scene);
  run.StepTo(kTime / 2);
  const Motion middle = run[0];
  run.StepTo(kTime);
  if (steeper < 0) {
    return {{"error", (run[0].position - Vector3(0, 0, half.z())).norm()},
            {"creep", (run[0].position - middle.position).norm() / (kTime / 2)}};
  }
  const double wanted = gravity * (std::sin(angle) - friction * std::cos(angle));
  const Vector3 got = (run[0].velocity - middle.velocity) / (kTime / 2);
  return {{"error", (run[0].position - wanted * kTime * kTime / 2 * down - Vector3(0, 0, half.z())).norm() /
                        (wanted * kTime * kTime / 2)},
          {"acceleration", (got - wanted * down).norm() / wanted}};
}

std::vector<Quantity> Braking(const Lab& lab, Dice& dice) {
  // A stop is located to an eighth of what braking does in a step: no path is so short that this shows.
  const double friction = dice.Between(0.1, 0.8), speed = dice.Between(3, 10), gravity = dice.Between(3, 12);
  const Vector3 heading = Heading(dice);
  const Vector3 half = AnyBlock(dice);
  Scene scene{.gravity = {0, 0, -gravity}, .has_ground = true, .friction = friction};
  scene.Add(Box{half}, dice.LogBetween(0.01, 100), {{0, 0, half.z()}, Turn(dice.Next(), Vector3::UnitZ())},
            speed * heading);
  const double path = speed * speed / (2 * friction * gravity);
  Run run = lab.Start(scene);
  run.StepTo(WholeSteps(lab, speed / (friction * gravity) + 0.3));
  const Quaternion turned = run[0].orientation * scene.bodies[0].pose.orientation.conjugate();
  return {{"error", (run[0].position - path * heading - Vector3(0, 0, half.z())).norm() / path},
          {"turn_degrees", 2 * std::asin(std::min(1.0, turned.vec().norm())) * 180 / std::numbers::pi}};
}

// Thrown with any spin about the axis that it will roll about.
std::vector<Quantity> SlideThenRoll(const Lab& lab, Dice& dice) {
  constexpr double kTime = 3;
  const double radius = dice.LogBetween(0.03, 0.5), friction = dice.Between(0.1, 0.6), speed = dice.Between(2, 8);
  const double rim = dice.Between(-0.5, 0.5) * speed;
  const Vector3 heading = Heading(dice);
  Scene scene{.has_ground = true, .friction = friction};
  scene.Add(Sphere{radius}, dice.LogBetween(0.01, 100), At(0, 0, radius), speed * heading,
            rim / radius * Vector3::UnitZ().cross(heading));
  const double slowing = friction * kGravity;
  const double until = std::min(kTime, (speed - rim) / (3.5 * slowing));
  const double rolling = speed - slowing * until;
  const double path = speed * until - slowing * until * until / 2 + rolling * (kTime - until);
  Run run = lab.Start(scene);
  run.StepTo(kTime);
  const double meters = (run[0].position - path * heading - Vector3(0, 0, radius)).norm();
  return {{"error", meters / path}, {"meters", meters}};
}

std::vector<Quantity> Bouncing(const Lab& lab, Dice& dice) {
  const double e = dice.Between(0.6, 0.95), drop = dice.Between(0.3, 3), gravity = dice.Between(3, 20);
  const double radius = dice.LogBetween(0.03, 0.5);
  Scene scene{.gravity = {0, 0, -gravity}, .has_ground = true, .friction = dice.Between(0, 1), .restitution = e};
  scene.Add(Sphere{radius}, dice.LogBetween(0.01, 100), At(0, 0, radius + drop));
  Run run = lab.Start(scene);
  BounceWatch watch(radius, drop, gravity);
  const double rest = std::sqrt(2 * drop / gravity) * (1 + e) / (1 - e);
  run.StepTo(WholeSteps(lab, rest + 1), [&] { watch.See(run[0], run.time()); });
  return {{"error", watch.PeakError(e)}, {"rest_time", std::abs(watch.unrest() / rest - 1)}};
}

// Two spheres that meet after 0.3 s with some offset.
std::vector<Quantity> Meeting(const Lab& lab, Dice& dice) {
  constexpr double kMeeting = 0.3;
  constexpr double kTime = 0.6;
  const double r1 = dice.LogBetween(0.03, 0.3), r2 = dice.LogBetween(0.03, 0.3);
  const double m1 = dice.LogBetween(0.1, 10), m2 = dice.LogBetween(0.1, 10), e = dice.Between(0, 1);
  const Vector3 v1 = 2 * dice.NextVector();
  const Vector3 apart = dice.NextVector().normalized();
  // Their approach is within 60 degrees of the line of their centres.
  const Vector3 aside = apart.cross(dice.NextVector()).normalized();
  const Vector3 drift = -dice.Between(2, 6) * (apart + dice.Between(0, 1.7) * aside);
  const Vector3 v2 = v1 + drift;
  const Vector3 x1 = -v1 * kMeeting, x2 = (r1 + r2) * apart - v2 * kMeeting;
  Scene scene{.gravity = Vector3::Zero(), .restitution = e};
  scene.Add(Sphere{r1}, m1, {.position = x1}, v1);
  scene.Add(Sphere{r2}, m2, {.position = x2}, v2);
  const Vector3 push = (1 + e) * drift.dot(apart) / (1 / m1 + 1 / m2) * apart;
  const Vector3 after1 = v1 + push / m1, after2 = v2 - push / m2;
  Run run = lab.Start(scene);
  run.StepTo(kTime);
  const double left = kTime - kMeeting;
  return {{"error", std::max((run[0].velocity - after1).norm(), (run[1].velocity - after2).norm()) / drift.norm()},
          {"place", std::max((run[0].position - after1 * left).norm(),
                             (run[1].position - (r1 + r2) * apart - after2 * left).norm())}};
}

// Gravity is such that half a period takes 1 s: at 2.5 s it comes through the bottom, where it is fastest.
std::vector<Quantity> Swinging(const Lab& lab, Dice& dice) {
  constexpr double kHalfPeriod = 1;
  const Vector3 half(dice.Between(0.2, 1), dice.LogBetween(0.01, 0.2), dice.LogBetween(0.01, 0.2));
  const double mass = dice.LogBetween(0.1, 10), amplitude = dice.Between(0.3, 2.8);
  // From its middle to the hinge.
  const double arm = dice.Between(0.5, 1) * half.x();
  const double moment = mass * (half.x() * half.x() + half.z() * half.z()) / 3 + mass * arm * arm;
  const double rate = 2 * std::comp_ellint_1(std::sin(amplitude / 2)) / kHalfPeriod;
  Scene scene{.gravity = {0, 0, -rate * rate * moment / (mass * arm)}};
  const Vector3 axis = Heading(dice);
  // Its x points from the hinge to its middle.
  Matrix3 hanging;
  hanging << -Vector3::UnitZ(), axis, -Vector3::UnitZ().cross(axis);
  const Quaternion turn = Turn(amplitude, axis) * Quaternion(hanging);
  const size_t rod = scene.Add(Box{half}, mass, {turn * Vector3(arm, 0, 0), turn});
  scene.Join(HingeJoint{}, std::nullopt, rod, Vector3::Zero(), axis);
  Run run = lab.Start(scene);
  const double energy = run.Energy();
  double gap = 0;
  run.StepTo(2.5 * kHalfPeriod, [&] { gap = std::max(gap, run.JointGap()); });
  const double span = -mass * scene.gravity.z() * arm;
  return {{"error", (run[rod].position + Vector3(0, 0, arm)).norm() / arm},
          {"gap", gap / arm},
          {"energy", std::abs(run.Energy() - energy) / span}};
}

// A box on a hinge that lies anywhere in it or near it and mostly along none of its axes, so small that it swings in a
// fraction of a second.
std::vector<Quantity> SmallSwing(const Lab& lab, Dice& dice) {
  constexpr double kTime = 20, kPart = 2;
  const Vector3 half(dice.LogBetween(0.01, 0.1), dice.LogBetween(0.01, 0.1), dice.LogBetween(0.01, 0.1));
  const double arm = dice.Between(0.3, 1.5) * half.maxCoeff();
  const Vector3 out = Heading(dice);
  Scene scene;
  scene.Add(Box{half}, 1, {arm * out, Turn(3 * dice.Next(), dice.NextVector().normalized())});
  const Vector3 across = Vector3::UnitZ().cross(out) + dice.Between(-0.3, 0.3) * Vector3::UnitZ();
  scene.Join(HingeJoint{}, std::nullopt, 0, Vector3::Zero(), across.normalized());
  Run run = lab.Start(scene);
  // Velocities that are shown are as right as a step is: what a few swings have in the mean counts.
  const auto mean_until = [&](double time) {
    double sum = 0;
    int count = 0;
    run.StepTo(time, [&] { sum += run.Energy(), ++count; });
    return sum / count;
  };
  const double first = mean_until(kPart);
  run.StepTo(kTime - kPart);
  return {{"error", std::abs(mean_until(kTime) - first) / (kGravity * 2 * arm)}, {"gap", run.JointGap()}};
}

std::vector<Quantity> Tumbling(const Lab& lab, Dice& dice) {
  Scene scene;
  scene.gravity.setZero();
  const double a = dice.LogBetween(0.05, 1), b = dice.LogBetween(0.05, 1), c = dice.LogBetween(0.05, 1);
  scene.Add(Box{{a, b, c}}, dice.LogBetween(0.1, 10), {Vector3::Zero(), Turn(dice.Next(), Vector3::UnitX())},
            dice.NextVector(), 10 * dice.NextVector());
  Run run = lab.Start(scene);
  const double energy = run.KineticEnergy();
  const Vector3 momentum = run.AngularMomentum();
  run.StepTo(10);
  return {{"error", (run.AngularMomentum() - momentum).norm() / momentum.norm()},
          {"energy", std::abs(run.KineticEnergy() / energy - 1)}};
}

}  // namespace

void AddAny(std::vector<Problem>& problems) {
  problems.push_back(Any("A5.any", "tumbling box for 10 s", "angular momentum, relative", Tumbling));
  problems.push_back(Any("B1.any", "rod hung anywhere, from 17 to 160 degrees", "place at 2.5 s / arm", Swinging));
  problems.push_back(
      Any("B1.small", "box of 2 to 20 cm swings on a hinge for 20 s", "energy / (m g 2 arm)", SmallSwing));
  problems.push_back(Any("C1.stick.any", "block on a slope, a hundredth less steep", "place after 2 s / 1 m",
                         [](const Lab& lab, Dice& dice) { return OnSlope(lab, dice, -0.01); }));
  problems.push_back(Any("C1.slip.any", "block on a slope, a hundredth steeper", "place after 2 s / its path",
                         [](const Lab& lab, Dice& dice) { return OnSlope(lab, dice, 0.01); }));
  problems.push_back(Any("C2.any", "block slides to a stop", "where it stops / its path", Braking));
  problems.push_back(Any("C3.any", "ball slides until it rolls", "place after 3 s / its path", SlideThenRoll));
  problems.push_back(Any("C5.any", "ball falls", "height of the first four peaks, relative", Bouncing));
  problems.push_back(Any("C6.any", "two spheres meet aslant", "velocities after it / speed of approach", Meeting));
}

}  // namespace genphys::bench

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "problem.h"
#include "references.h"

namespace genphys::bench {
namespace {

constexpr double kFriction = 0.5;
constexpr double kBlockHeight = 0.1;

Pose OnFloor() { return At(0, 0, kBlockHeight / 2); }
Shape Block() { return Box{{0.2, 0.2, kBlockHeight / 2}}; }

// A floor under tilted gravity is a slope, and its coordinates are along it and across.
Scene BlockOnSlope(double angle) {
  Scene scene{.gravity = kGravity * Vector3(std::sin(angle), 0, -std::cos(angle)), .has_ground = true};
  scene.friction = kFriction;
  scene.Add(Block(), 1, OnFloor());
  return scene;
}

Problem Stick() {
  constexpr double kTime = 3;
  Problem problem{.id = "C1.stick",
                  .title = "block on a slope, a hundredth less steep than friction holds",
                  .error = "place after 3 s / 1 m",
                  .scene = BlockOnSlope(reference::kStickAngle),
                  .duration = kTime};
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime - 1);
    const Vector3 before = run[0].position;
    run.StepTo(kTime);
    return {{"error", (run[0].position - OnFloor().position).norm()}, {"creep", (run[0].position - before).norm()}};
  };
  return problem;
}

Problem Slip() {
  constexpr double kTime = 2;
  constexpr double kPath = reference::kSlipAcceleration * kTime * kTime / 2;
  Problem problem{.id = "C1.slip",
                  .title = "block on a slope, a hundredth steeper than friction holds",
                  .error = "place after 2 s / 0.0876 m",
                  .scene = BlockOnSlope(reference::kSlipAngle),
                  .duration = kTime};
  problem.euler_error = reference::kSlipAcceleration * kTime / 2 / kPath;
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime / 2);
    const double before = run[0].velocity.x();
    run.StepTo(kTime);
    const double acceleration = (run[0].velocity.x() - before) / (kTime / 2);
    return {{"error", std::abs(run[0].position.x() - kPath) / kPath},
            {"acceleration", std::abs(acceleration / reference::kSlipAcceleration - 1)}};
  };
  return problem;
}

constexpr double kStopSpeed = 5;

Scene SlidingBlock(double heading, bool on_box) {
  Scene scene{.has_ground = !on_box, .friction = kFriction};
  scene.Add(Block(), 1, OnFloor(), kStopSpeed * Vector3(std::cos(heading), std::sin(heading), 0));
  if (on_box) scene.AddStatic(Box{{20, 20, 0.5}}, At(0, 0, -0.5));
  return scene;
}

// How far from where it should have stopped, relative, and by how many degrees it turned.
std::vector<Quantity> Stop(const Lab& lab, const Scene& scene) {
  constexpr double kTime = 1.5;
  Run run = lab.Start(scene);
  run.StepTo(kTime);
  const Vector3 moved = run[0].position - OnFloor().position;
  const Vector3 heading = scene.bodies[0].rigid_body->linear_velocity.normalized();
  const Vector3 forward = run[0].orientation * Vector3::UnitX();
  return {{"error", (moved - reference::kStopDistance * heading).norm() / reference::kStopDistance},
          {"distance", std::abs(moved.norm() / reference::kStopDistance - 1)},
          {"turn_degrees", std::abs(std::atan2(forward.y(), forward.x())) * 180 / std::numbers::pi}};
}

Problem Braking(const std::string& id, const std::string& floor, bool on_box) {
  Problem problem{.id = id,
                  .title = "block slides to a stop on " + floor,
                  .error = "where it stops / 2.548 m",
                  .scene = SlidingBlock(0, on_box),
                  .duration = 1};
  problem.euler_error = kStopSpeed / 2 / reference::kStopDistance;
  problem.measure = [scene = problem.scene](const Lab& lab) { return Stop(lab, scene); };
  return problem;
}

Problem BrakingAnyWay() {
  constexpr int kHeadings = 13;
  constexpr double kBetween = std::numbers::pi / 24;
  Problem problem{.id = "C2i",
                  .title = "the same in 13 directions from 0 to 90 degrees",
                  .error = "where it stops / 2.548 m, the worst",
                  .scene = SlidingBlock(3 * kBetween, false),
                  .duration = 1};
  problem.euler_error = kStopSpeed / 2 / reference::kStopDistance;
  problem.measure = [](const Lab& lab) {
    std::vector<Quantity> worst;
    for (int i = 0; i < kHeadings; ++i) {
      const std::vector<Quantity> each = Stop(lab, SlidingBlock(i * kBetween, false));
      if (worst.empty()) worst = each;
      for (size_t q = 0; q < each.size(); ++q) worst[q].value = std::max(worst[q].value, each[q].value);
    }
    return worst;
  };
  return problem;
}

Problem SlideThenRoll() {
  constexpr double kTime = 2;
  constexpr double kSpeed = 7;
  constexpr double kRadius = 0.1;
  Problem problem{.id = "C3",
                  .title = "ball thrown along a floor, slides until it rolls",
                  .error = "place after 2 s / 11.02 m",
                  .scene = {.has_ground = true, .friction = 0.2},
                  .duration = kTime};
  problem.scene.Add(Sphere{kRadius}, 1, At(0, 0, kRadius), {kSpeed, 0, 0});
  problem.euler_error = (kSpeed - 5) / 2 / reference::kSlideThenRoll;
  problem.measure = [scene = problem.scene](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    const double meters = std::abs(run[0].position.x() - reference::kSlideThenRoll);
    return {{"error", meters / reference::kSlideThenRoll},
            {"meters", meters},
            {"speed", std::abs(run[0].velocity.x() / 5 - 1)}};
  };
  return problem;
}

Problem Rolling(const std::string& id, const Shape& shape, const std::string& what, double path) {
  constexpr double kTime = 1;
  constexpr double kRadius = 0.1;
  const double angle = std::numbers::pi / 12;
  const Quaternion tilt = Turn(angle, Vector3::UnitY());
  const Vector3 down = tilt * Vector3::UnitX();
  Problem problem{.id = id,
                  .title = what + " rolls down 15 degrees",
                  .error = "place after 1 s / its path",
                  .scene = {.friction = kFriction},
                  .duration = kTime};
  problem.scene.AddStatic(Plane{tilt * Vector3::UnitZ(), 0});
  // A cylinder lies across the slope.
  const Pose pose{tilt * Vector3(0, 0, kRadius), tilt * Turn(-std::numbers::pi / 2, Vector3::UnitX())};
  problem.scene.Add(shape, 1, pose);
  problem.euler_error = 1 / kTime;
  problem.measure = [scene = problem.scene, pose, down, path](const Lab& lab) -> std::vector<Quantity> {
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    const double meters = (run[1].position - pose.position - path * down).norm();
    return {{"error", meters / path}, {"meters", meters}};
  };
  return problem;
}

}  // namespace

void AddSliding(std::vector<Problem>& problems) {
  problems.push_back(Stick());
  problems.push_back(Slip());
  problems.push_back(Braking("C2", "a plane", false));
  problems.push_back(Braking("C2.box", "a box", true));
  problems.push_back(BrakingAnyWay());
  problems.push_back(SlideThenRoll());
  problems.push_back(Rolling("C19.ball", Sphere{0.1}, "ball", reference::kRollingBall));
  problems.push_back(Rolling("C19.cylinder", Cylinder{0.1, 0.1}, "cylinder", reference::kRollingCylinder));
}

}  // namespace genphys::bench

// What motors drive: what controllers and learning loops have.
#include <cmath>
#include <numbers>
#include <numeric>

#include "case.h"
#include "gauges.h"

namespace genphys::bench {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

constexpr int kArms = 20;
constexpr int kArmJoints = 6;

// Upright chains of six links, whose hinges take turns about z, x and y.
Scene Arms(const std::function<JointAxis(int joint)>& axis_of) {
  constexpr int kRow = 5;
  constexpr double kLink = 0.4;
  Scene scene{.has_ground = true, .friction = 0.5};
  for (int arm = 0; arm < kArms; ++arm) {
    const Vector3 foot(3 * (arm % kRow), 3 * (arm / kRow), 0.1);
    std::optional<size_t> below;
    for (int i = 0; i < kArmJoints; ++i) {
      const size_t link = scene.Add(Box{{0.05, 0.05, 0.15}}, 2, {.position = foot + Vector3(0, 0, kLink * (i + 0.5))});
      const Vector3 axis = i == 0 ? Vector3::UnitZ() : i % 2 == 1 ? Vector3::UnitX() : Vector3::UnitY();
      scene.Join(HingeJoint{axis_of(i)}, below, link, foot + Vector3(0, 0, kLink * i), axis);
      below = link;
    }
  }
  return scene;
}

Scene ArmsAtLimits() {
  return Arms([](int) {
    return JointAxis{
        .limits = {.lower = -0.4, .upper = 0.3}, .motor = Motor{.target_velocity = 0.3, .force_max = 60}, .spring = {}};
  });
}

Scene ServoArms() {
  return Arms([](int) {
    return JointAxis{.limits = {},
                     .motor = Motor{.target_position = 0, .stiffness = 4000, .damping = 200, .force_max = 200},
                     .spring = {}};
  });
}

// Where servos are asked to be: all of one arm, each a bit later than the one below.
struct Course {
  double middle = 0;  // rad
  double swing = 0;   // rad
  double rate = 0;    // 1/s

  double Position(double time) const { return middle + swing * std::sin(kTwoPi * rate * time); }
  double Velocity(double time) const { return swing * kTwoPi * rate * std::cos(kTwoPi * rate * time); }
};

std::function<void(Simulation&, double)> Follow(const std::vector<Course>& courses) {
  std::vector<size_t> joints(courses.size());
  std::iota(joints.begin(), joints.end(), size_t{0});
  return [courses, joints](Simulation& simulation, double time) {
    std::vector<double> positions, velocities;
    for (const Course& course : courses) {
      positions.push_back(course.Position(time));
      velocities.push_back(course.Velocity(time));
    }
    simulation.Aim(joints, positions, velocities);
  };
}

Gauge OffCourse(const std::vector<Course>& courses) {
  return {"mean error of angles, rad", [courses](const Simulation& simulation, const Scene& scene, double time) {
            double sum = 0;
            for (size_t i = 0; i < courses.size(); ++i) {
              sum += std::abs(HingeAngle(simulation, scene, i) - courses[i].Position(time));
            }
            return sum / static_cast<double>(courses.size());
          }};
}

Gauge MeanAngle() {
  return {"mean angle, rad", [](const Simulation& simulation, const Scene& scene, double) {
            double sum = 0;
            for (size_t i = 0; i < scene.joints.size(); ++i) sum += HingeAngle(simulation, scene, i);
            return sum / static_cast<double>(scene.joints.size());
          }};
}

std::vector<Course> ArmCourses() {
  std::vector<Course> courses;
  for (int i = 0; i < kArms * kArmJoints; ++i) courses.push_back({.swing = i % 2 == 0 ? 0.3 : -0.3, .rate = 0.5});
  return courses;
}

Scene Cars() {
  constexpr int kCount = 25, kRow = 5;
  constexpr double kRadius = 0.35, kSpin = 6, kTorque = 60;
  Scene scene{.has_ground = true, .friction = 0.8};
  for (int i = 0; i < kCount; ++i) {
    const Vector3 place(6 * (i % kRow), 4 * (i / kRow), 0.01);
    const size_t body = scene.Add(Box{{1, 0.5, 0.2}}, 100, {.position = place + Vector3(0, 0, 0.6)});
    for (const double x : {-0.7, 0.7}) {
      for (const double y : {-0.65, 0.65}) {
        const Vector3 hub = place + Vector3(x, y, kRadius);
        const size_t wheel = scene.Add(Cylinder{kRadius, 0.1}, 10, {hub, Turn(std::numbers::pi / 2, Vector3::UnitX())});
        JointAxis spin;
        if (x < 0) spin.motor = Motor{.target_velocity = kSpin, .force_max = kTorque};
        scene.Join(HingeJoint{spin}, body, wheel, hub, Vector3::UnitY());
      }
    }
  }
  return scene;
}

Scene Belt() {
  constexpr int kCount = 200, kRow = 20;
  Scene scene{.friction = 0.5};
  const size_t belt = scene.AddStatic(Box{{200, 20, 0.5}}, At(0, 0, -0.5));
  scene.bodies[belt].rigid_body->geometries[0].surface_velocity = {1, 0, 0};
  for (int i = 0; i < kCount; ++i) scene.Add(Box{{0.3, 0.3, 0.3}}, 1, At(i % kRow - 10, i / kRow - 5, 0.35));
  return scene;
}

constexpr double kThigh = 0.3, kShin = 0.3;  // m

// A trunk on four legs of two links: hips and knees about y.
Scene Walker() {
  Scene scene{.has_ground = true, .friction = 0.8};
  const double hip = kThigh + kShin + 0.02;
  const size_t trunk = scene.Add(Box{{0.35, 0.15, 0.06}}, 10, At(0, 0, hip + 0.02));
  const JointAxis servo{.limits = {},
                        .motor = Motor{.target_position = 0, .stiffness = 400, .damping = 10, .force_max = 80},
                        .spring = {}};
  for (const double x : {-0.3, 0.3}) {
    for (const double y : {-0.22, 0.22}) {
      const size_t thigh = scene.Add(Capsule{0.03, kThigh / 2 - 0.03}, 1, At(x, y, hip - kThigh / 2));
      const size_t shin = scene.Add(Capsule{0.02, kShin / 2 - 0.02}, 0.5, At(x, y, hip - kThigh - kShin / 2));
      scene.Join(HingeJoint{servo}, trunk, thigh, {x, y, hip}, Vector3::UnitY());
      scene.Join(HingeJoint{servo}, thigh, shin, {x, y, hip - kThigh}, Vector3::UnitY());
    }
  }
  return scene;
}

// It goes up and down on bent knees.
std::vector<Course> WalkerCourses() {
  std::vector<Course> courses;
  for (int leg = 0; leg < 4; ++leg) {
    courses.push_back({.middle = 0.4, .swing = 0.1, .rate = 1});
    courses.push_back({.middle = -0.8, .swing = -0.2, .rate = 1});
  }
  return courses;
}

}  // namespace

void AddDriven(std::vector<Case>& cases) {
  cases.push_back({.id = "arms",
                   .title = "20 arms of six joints, whose motors drive them to their limits and hold them there",
                   .make = ArmsAtLimits,
                   .phases = {{"turning", 0, 0.8}, {"at their limits", 2, 1}},
                   .gauge = MeanAngle()});
  cases.push_back({.id = "servos",
                   .title = "20 arms of six joints, whose servos follow a course that is told at every step",
                   .make = ServoArms,
                   .phases = {{"on their way", 1, 2}},
                   .drive = Follow(ArmCourses()),
                   .gauge = OffCourse(ArmCourses())});
  cases.push_back({.id = "walker",
                   .title = "one four-legged robot of eight servos goes up and down: what learning loops run",
                   .make = Walker,
                   .phases = {{"standing", 1, 3}},
                   .rate = 240,
                   .drive = Follow(WalkerCourses()),
                   .gauge = OffCourse(WalkerCourses())});
  cases.push_back({.id = "cars",
                   .title = "25 cars drive on the floor, two of their four wheels on motors",
                   .make = Cars,
                   .phases = {{"driving", 1, 2}},
                   .gauge = SpeedAlongX()});
  cases.push_back({.id = "belt",
                   .title = "200 boxes lie on a belt that runs",
                   .make = Belt,
                   .phases = {{"running", 1, 2}},
                   .gauge = SpeedAlongX()});
}

}  // namespace genphys::bench

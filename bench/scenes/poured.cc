// What falls in heaps onto a floor, by its shape.
#include <cmath>

#include "case.h"
#include "contenders/dice.h"
#include "genphys/convex_hull.h"
#include "support/must.h"

namespace genphys::bench {
namespace {

// Adds the body of a number at a place above the floor.
using Maker = std::function<void(Scene& scene, int number, const Pose& pose)>;

// Four layers of 16, each in disorder.
Scene Poured(const Maker& add, double restitution) {
  constexpr int kRow = 4, kCount = kRow * kRow * kRow;
  constexpr double kSpacing = 1.3, kRise = 1.15, kAside = 0.3;
  Scene scene{.has_ground = true, .friction = 0.5, .restitution = restitution};
  Dice dice(kSeed);
  for (int i = 0; i < kCount; ++i) {
    const int layer = i / (kRow * kRow), column = i % kRow, row = i / kRow % kRow;
    const double aside = layer % 2 == 0 ? -kAside : kAside;
    const double x = kSpacing * column + aside + 0.02 * dice.Next(), y = kSpacing * row + aside + 0.02 * dice.Next();
    Pose pose = At(x, y, 0.7 + kRise * layer);
    pose.orientation = Turn(0.3 * dice.Next(), Vector3::UnitZ());
    add(scene, i, pose);
  }
  return scene;
}

void AddParts(Scene& scene, const std::vector<Geometry>& parts, const Pose& pose) {
  RigidBody body{.geometries = parts};
  body.inertia.mass = 1;
  scene.bodies.push_back({.pose = pose, .rigid_body = body});
}

void AddCylinder(Scene& scene, int, const Pose& pose) { scene.Add(Cylinder{0.5, 0.5}, 1, pose); }

void AddEllipsoid(Scene& scene, int, const Pose& pose) { scene.Add(Ellipsoid{{0.5, 0.4, 0.3}}, 1, pose); }

// About its centre of mass, which is a quarter of its height above the base.
void AddCone(Scene& scene, int, const Pose& pose) {
  AddParts(scene, {{.shape = Cone{0.5, 0.5}, .pose_in_entity = At(0, 0, 0.25)}}, pose);
}

// Three crossed bars.
void AddJack(Scene& scene, int number, const Pose& pose) {
  constexpr double kLong = 0.5, kThin = 0.12;
  const Quaternion tilt = Turn(0.1 * (number % 7), Vector3(1, 1, 0).normalized());
  AddParts(scene,
           {{.shape = Box{{kLong, kThin, kThin}}},
            {.shape = Box{{kThin, kLong, kThin}}},
            {.shape = Box{{kThin, kThin, kLong}}}},
           {pose.position, pose.orientation * tilt});
}

// Twenty corners in pairs, so that its centre of mass is in the middle.
void AddHull(Scene& scene, int number, const Pose& pose) {
  constexpr int kPairs = 10;
  constexpr double kRadius = 0.5;
  // Like a sunflower's seeds, over the sphere.
  constexpr double kTurn = 2.399963;
  std::vector<Vector3> corners;
  for (int i = 0; i < kPairs; ++i) {
    const double z = 1 - 2 * (i + 0.5) / kPairs, width = std::sqrt(1 - z * z);
    const Vector3 corner = kRadius * Vector3(width * std::cos(kTurn * i), width * std::sin(kTurn * i), z);
    corners.push_back(corner);
    corners.push_back(-corner);
  }
  const Quaternion tilt = Turn(0.3 * (number % 11), Vector3(1, 2, 3).normalized());
  scene.Add(Must(MakeConvexHull(corners)), 1, {pose.position, pose.orientation * tilt});
}

// Boxes, balls, capsules, cylinders, hulls and jacks in turn.
void AddAny(Scene& scene, int number, const Pose& pose) {
  switch (number % 6) {
    case 0:
      scene.Add(Box{{0.5, 0.5, 0.5}}, 1, pose);
      return;
    case 1:
      scene.Add(Sphere{0.5}, 1, pose);
      return;
    case 2:
      scene.Add(Capsule{0.3, 0.25}, 1, {pose.position, pose.orientation * Turn(1, Vector3::UnitX())});
      return;
    case 3:
      return AddCylinder(scene, number, pose);
    case 4:
      return AddHull(scene, number, pose);
    default:
      return AddJack(scene, number, pose);
  }
}

Scene Balls() {
  constexpr int kCount = 100, kRow = 10;
  Scene scene{.has_ground = true, .friction = 0.5, .restitution = 0.8};
  Dice dice(kSeed);
  for (int i = 0; i < kCount; ++i) scene.Add(Sphere{0.3}, 1, At(2 * (i % kRow), 2 * (i / kRow), dice.Between(1, 3)));
  return scene;
}

// Of the energy that they began with. Without loss but by bounces at e = 0.8 a part of it is left.
Gauge Bouncing() {
  return {"energy left, of all", [](const Simulation& simulation, const Scene& scene, double) {
            double before = 0, now = 0;
            for (size_t i = 0; i < scene.bodies.size(); ++i) {
              const double floor = std::get<Sphere>(scene.bodies[i].rigid_body->geometries[0].shape).radius;
              const Motion motion = simulation.MotionOf(i);
              before += kGravity * (scene.bodies[i].pose.position.z() - floor);
              now += kGravity * (motion.position.z() - floor) + motion.velocity.squaredNorm() / 2;
            }
            return now / before;
          }};
}

void Add(std::vector<Case>& cases, const std::string& id, const std::string& title, const Maker& maker) {
  cases.push_back({.id = id,
                   .title = title,
                   .make = [maker] { return Poured(maker, 0.2); },
                   .phases = {{"falling", 0, 1.5}, {"lying", 4, 1}}});
}

}  // namespace

void AddPoured(std::vector<Case>& cases) {
  Add(cases, "cylinders", "64 cylinders fall onto each other", AddCylinder);
  Add(cases, "cones", "64 cones fall onto each other", AddCone);
  Add(cases, "ellipsoids", "64 ellipsoids fall onto each other", AddEllipsoid);
  Add(cases, "hulls", "64 hulls of 20 corners fall onto each other", AddHull);
  Add(cases, "jacks", "64 bodies of three crossed boxes fall onto each other", AddJack);
  Add(cases, "mixed", "64 boxes, balls, capsules, cylinders, hulls and jacks fall onto each other", AddAny);
  cases.push_back({.id = "balls",
                   .title = "100 balls bounce, each by itself, e = 0.8",
                   .make = Balls,
                   .phases = {{"bouncing", 0, 3}},
                   .gauge = Bouncing()});
}

}  // namespace genphys::bench

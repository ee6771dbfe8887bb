// Friction of what is solved all at once: of what joints hold together, and of what is heavy on something light. It is
// Coulomb's, whichever way it acts.
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointedFriction, Claim::kContacts, Claim::kStaticFriction);

constexpr double kGravity = 9.81, kFriction = 0.5;

// A floor that gravity makes a slope, `ratio` times as steep as friction holds, down towards `heading`.
std::unique_ptr<World> MakeSlope(const std::string& engine, double rate, double ratio, double heading) {
  const double angle = std::atan(ratio * kFriction);
  WorldDesc desc{.engine = engine,
                 .gravity = kGravity * Vector3(std::sin(angle) * std::cos(heading), std::sin(angle) * std::sin(heading),
                                               -std::cos(angle)),
                 .stepper = {.step_size = 1 / rate}};
  desc.default_material.friction = kFriction;
  desc.default_auto_disable.enabled = false;
  return testing::MakeWorld(desc);
}

// m: how far what slips goes down it.
double WayDown(double ratio, double time) {
  const double angle = std::atan(ratio * kFriction);
  return std::max(0.0, kGravity * (std::sin(angle) - kFriction * std::cos(angle))) * time * time / 2;
}

// m: softness lets points give way by some part of the speed that what they bear, of `load` times their own mass, gets
// in a step.
double Off(const World& world, double time, double load = 1) {
  return 2 * kSwept * load * kGravity * SubstepOf(world) * time;
}

TEST_P(JointedFriction, APairOnASlopeSlipsAsOneAloneDoes) {
  Proves({Claim::kPlane, Claim::kBox, Claim::kJointHinge, Claim::kJointFixed});
  constexpr double kTime = 0.5;
  for (const JointKind& kind : {JointKind{FixedJoint{}}, JointKind{HingeJoint{}}}) {
    for (const double ratio : {0.95, 1.05, 1.2, 1.35}) {
      for (const double heading : {0.0, 0.4, 0.8}) {
        for (const double rate : {60.0, 240.0}) {
          const auto world = MakeSlope(GetParam(), rate, ratio, heading);
          const EntityId a = Add(*world, Body(Box{{0.2, 0.2, 0.1}}, {0, -0.5, 0.1}));
          const EntityId b = Add(*world, Body(Box{{0.2, 0.2, 0.1}}, {0, 0.5, 0.1}));
          Join(*world, Between(a, b, kind, Pose{{0, 0.5, 0}, {1, 0, 0, 0}}));
          Steps(*world, static_cast<int>(std::lround(kTime * rate)));
          const Vector3 way = WayDown(ratio, kTime) * Vector3(std::cos(heading), std::sin(heading), 0);
          EXPECT_LE((PositionOf(*world, a) - Vector3(0, -0.5, 0.1) - way).head<2>().norm(), Off(*world, kTime))
              << ratio << " heading " << heading << " at " << rate << " joint " << kind.index();
        }
      }
    }
  }
}

TEST_P(JointedFriction, ACarWithLockedBrakesSlipsHoweverItStands) {
  Proves({Claim::kPlane, Claim::kSphere, Claim::kJointHinge, Claim::kJointMotor});
  constexpr double kTime = 0.5, kRadius = 0.2, kCar = 4, kWheel = 0.5, kLoad = (kCar / 3 + kWheel) / kWheel;
  for (const double ratio : {0.95, 1.05, 1.2, 1.35}) {
    for (const double heading : {0.0, 0.4, 0.8}) {
      for (const double rate : {60.0, 240.0}) {
        const auto world = MakeSlope(GetParam(), rate, ratio, heading);
        EntityDesc body = Body(Box{{0.6, 0.3, 0.1}}, {0, 0, 0.35}, kCar);
        body.rigid_body->geometries[0].collides_with_bits = 0;
        const EntityId car = Add(*world, body);
        for (const Vector3& at :
             {Vector3(-0.4, -0.35, kRadius), Vector3(-0.4, 0.35, kRadius), Vector3(0.5, 0, kRadius)}) {
          const EntityId wheel = Add(*world, Ball(at, kRadius, kWheel));
          const JointAxis locked{.limits = {}, .motor = Motor{}, .spring = {}};
          Join(*world, Between(car, wheel, HingeJoint{locked}, FrameAlong(Vector3::UnitY(), at - Vector3(0, 0, 0.35))));
        }
        Steps(*world, static_cast<int>(std::lround(kTime * rate)));
        const Vector3 way = WayDown(ratio, kTime) * Vector3(std::cos(heading), std::sin(heading), 0);
        EXPECT_LE((PositionOf(*world, car) - Vector3(0, 0, 0.35) - way).head<2>().norm(), Off(*world, kTime, kLoad))
            << ratio << " heading " << heading << " at " << rate;
      }
    }
  }
}

TEST_P(JointedFriction, AGripperHoldsWhatItsPadsBear) {
  Proves({Claim::kBox, Claim::kJointSlider, Claim::kJointMotor});
  constexpr double kTime = 0.3;
  for (const double force : {7.0, 9.0, 9.7, 9.9, 12.0}) {
    for (const double rate : {60.0, 240.0}) {
      const auto world = MakeSpace(GetParam(), {.step_size = 1 / rate}, {0, 0, -kGravity});
      EntityDesc crate = Crate({0, 0, 1}, 0.1);
      crate.rigid_body->geometries[0].material.friction = kFriction;
      const EntityId held = Add(*world, crate);
      for (const double side : {-1.0, 1.0}) {
        EntityDesc pad = Body(Box{{0.02, 0.05, 0.1}}, {side * 0.12, 0, 1}, 0.2);
        pad.rigid_body->geometries[0].material.friction = kFriction;
        SliderJoint slider;
        slider.axis.motor = Motor{.target_velocity = 10, .force_max = force};
        Join(*world, ToWorld(Add(*world, pad), slider, FrameAlong({-side, 0, 0}, {side * 0.12, 0, 1})));
      }
      Steps(*world, static_cast<int>(std::lround(kTime * rate)));
      const double way = std::max(0.0, kGravity - 2 * kFriction * force) * kTime * kTime / 2;
      EXPECT_NEAR(1 - PositionOf(*world, held).z(), way, Off(*world, kTime)) << force << " N at " << rate;
    }
  }
}

TEST_P(JointedFriction, WhatIsHeavySlidesOnSomethingLightWhicheverWayItIsPushed) {
  Proves({Claim::kPlane, Claim::kBox, Claim::kForce});
  constexpr double kTime = 0.5, kHeavy = 200, kLight = 1;
  constexpr double kBorne = kFriction * (kHeavy + kLight) * kGravity;
  for (const double part : {0.95, 1.05, 1.2, 1.5}) {
    for (const double heading : {0.0, 0.4, std::numbers::pi / 4}) {
      const auto world = MakeSlope(GetParam(), 60, 0, 0);
      const EntityId slab = Add(*world, Body(Box{{0.5, 0.5, 0.05}}, {0, 0, 0.05}, kLight));
      EntityDesc load = Body(Box{{0.3, 0.3, 0.1}}, {0, 0, 0.2}, kHeavy);
      // By the geometric mean four times as much as on the floor.
      load.rigid_body->geometries[0].material.friction = 16 * kFriction;
      const EntityId pushed = Add(*world, load);
      const Vector3 way(std::cos(heading), std::sin(heading), 0);
      Do(*world, ApplyForce{.id = pushed, .force = part * kBorne * way, .steps = 1000});
      Steps(*world, 30);
      const double gain = std::max(0.0, part - 1) * kBorne / (kHeavy + kLight), far = gain * kTime * kTime / 2;
      EXPECT_LE((PositionOf(*world, pushed) - Vector3(0, 0, 0.2) - far * way).head<2>().norm(),
                Off(*world, kTime) + gain * SubstepOf(*world) * kTime)
          << "but for the solve in which it begins: " << part << " heading " << heading;
      EXPECT_LE((PositionOf(*world, pushed) - PositionOf(*world, slab)).head<2>().norm(), Off(*world, kTime));
    }
  }
}

// Three balls on a floor, welded or one body: how their middle and one of them are where they slid and spun to.
Eigen::Matrix<double, 3, 2> Slid(const std::string& engine, double rate, double time, bool welded) {
  const double radius = 0.05, reach = 0.2;
  const Vector3 spin(0, 0, 6), speed(1.5, 0.4, 0);
  const Vector3 places[] = {{reach, 0, radius}, {-reach, 0, radius}, {0, reach, radius}};
  const Vector3 middle = (places[0] + places[1] + places[2]) / 3;
  const auto world = MakeSlope(engine, rate, 0, 0);
  std::vector<EntityId> ids;
  EntityDesc one = Body(Sphere{radius}, middle, 3);
  one.rigid_body->geometries.clear();
  for (const Vector3& place : places) {
    Geometry part = Ball({}, radius).rigid_body->geometries[0];
    part.pose_in_entity.position = place - middle;
    one.rigid_body->geometries.push_back(part);
    EntityDesc ball = Ball(place, radius);
    ball.rigid_body->linear_velocity = speed + spin.cross(place - middle);
    ball.rigid_body->angular_velocity = spin;
    if (welded) ids.push_back(Add(*world, ball));
  }
  one.rigid_body->linear_velocity = speed;
  one.rigid_body->angular_velocity = spin;
  if (!welded) ids.push_back(Add(*world, one));
  for (size_t i = 1; i < ids.size(); ++i)
    Join(*world, Between(ids[0], ids[i], FixedJoint{}, Pose{places[i] - places[0], {1, 0, 0, 0}}));
  Steps(*world, static_cast<int>(std::lround(time * rate)));
  Eigen::Matrix<double, 3, 2> slid;
  if (welded) {
    slid.col(0) = (PositionOf(*world, ids[0]) + PositionOf(*world, ids[1]) + PositionOf(*world, ids[2])) / 3;
    slid.col(1) = PositionOf(*world, ids[0]);
  } else {
    const Pose pose = world->state().pose(EntityRow{ids[0].index()});
    slid.col(0) = pose.position;
    slid.col(1) = pose.Transform(places[0] - middle);
  }
  return slid;
}

TEST_P(JointedFriction, AWeldedTrioSlidesAndSpinsAsOneBody) {
  Proves({Claim::kPlane, Claim::kSphere, Claim::kCompound, Claim::kJointFixed});
  constexpr double kTime = 0.2, kSpin = 6;
  const auto exact = Slid(GetParam(), 3840, kTime, false);
  for (const double rate : {60.0, 240.0, 960.0}) {
    // Friction is told by the slip at the ends of steps, which turns with the trio.
    const double turn = kSpin / rate;
    const double off = kFriction * kGravity * kTime * kTime / 2 * turn * turn;
    EXPECT_LE((Slid(GetParam(), rate, kTime, true) - exact).norm(), off) << rate;
  }
}

}  // namespace
}  // namespace genphys::testing

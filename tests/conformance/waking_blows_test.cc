// A sleeper that is hit goes where it would have gone awake: what it lies on takes part in the blow, and what pressed
// it is no news to it.
#include <algorithm>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(WakingBlows, Claim::kSleeping, Claim::kContacts);

std::unique_ptr<World> Floor(const std::string& engine, bool sleeps, double restitution) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -9.81}};
  desc.default_material = {.friction = 0.5, .restitution = restitution};
  desc.default_auto_disable = {.enabled = sleeps};
  return MakeWorld(desc);
}

// Who strikes comes at its own time, long after the others sleep.
EntityDesc Striker(EntityDesc body) {
  body.rigid_body->auto_disable = AutoDisable{.enabled = false};
  return body;
}

struct Beam {
  double half_length = 0.2;  // m
  double mass = 4;           // kg
  double height = 0.2;       // m, of its hinge
  double lean = 0.05;        // rad, from which it falls
};

// It stands on its hinge at the origin, leans along x, and falls that way.
void AddBeam(World& world, const Beam& beam) {
  const Quaternion turn(Eigen::AngleAxisd(beam.lean, Vector3::UnitY()));
  const Vector3 hinge(0, 0, beam.height), up = turn * Vector3(0, 0, beam.half_length);
  EntityDesc desc = Striker(Body(Box{{0.04, 0.04, beam.half_length}}, hinge + up, beam.mass));
  desc.pose.orientation = turn;
  const EntityId id = Add(world, desc);
  JointDesc joint = ToWorld(id, HingeJoint{}, FrameAlong(Vector3::UnitY(), hinge));
  joint.frame_in_b = FrameAlong(Vector3::UnitY(), Vector3(0, 0, -beam.half_length));
  Join(world, joint);
}

TEST_P(WakingBlows, WhatAHingedBeamStrikesStaysOnItsFloor) {
  Proves({Claim::kJointHinge});
  Require(*MakeSpace(GetParam()), Feature::kJointHinge);
  struct Case {
    Beam beam;
    Vector3 box;         // m, half extents
    double place, side;  // m, of its middle
  };
  // So far out that the beam comes down on it steeply: what friction bears does not go anywhere.
  for (const auto& [beam, box, place, side] : {Case{{.227, 4.777, .086, .096}, {.05, .05, .09}, .312, -.005},
                                               Case{{.174, 4.865, .179, .029}, {.05, .05, .077}, .375, .017},
                                               Case{{.273, 3.575, .247, .035}, {.05, .05, .085}, .41, -.019}}) {
    const auto world = Floor(GetParam(), true, 0);
    const Vector3 start(place, side, box.z());
    const EntityId id = Add(*world, Body(Box{box}, start, 0.5));
    Steps(*world, 60);
    ASSERT_TRUE(Asleep(*world, id));
    AddBeam(*world, beam);
    bool is_hit = false;
    for (int step = 0; step < 120; ++step) {
      Steps(*world, 1);
      is_hit |= !Asleep(*world, id);
    }
    EXPECT_TRUE(is_hit);
    // Up to 7e-6 m were seen, from the beam that comes to rest on it; without its floor in the blow 2e-3 to 1.1e-2.
    EXPECT_LE((PositionOf(*world, id) - start).norm(), 2e-5) << "of a box at " << place << " m";
  }
}

// A ball rolls into the lowest of three that lie on each other, whom that gives a push to the side.
TEST_P(WakingBlows, WhatBoreASleeperThrowsItBackNoMoreThanWhenItWasAwake) {
  Require(*MakeWorld(), Feature::kContacts);
  constexpr double kSpeed = 2.7, kRadius = 0.06;
  for (const double side : {-0.03, 0.01, 0.04}) {
    double fastest[2] = {};  // m/s, upwards, of those above
    for (const bool sleeps : {false, true}) {
      const auto world = Floor(GetParam(), sleeps, 0.4);
      std::vector<EntityId> tower;
      for (int i = 0; i < 3; ++i) tower.push_back(Add(*world, Crate({0, side, 0.05 + 0.1 * i}, 0.05, 0.4)));
      Steps(*world, 60);
      ASSERT_EQ(Asleep(*world, tower.front()), sleeps);
      EntityDesc ball = Striker(Ball({-0.2, 0, kRadius}, kRadius));
      ball.rigid_body->linear_velocity = {kSpeed, 0, 0};
      ball.rigid_body->angular_velocity = {0, kSpeed / kRadius, 0};
      Add(*world, ball);
      int steps = 0;
      for (; VelocityOf(*world, tower.front()).norm() < 0.1 && steps < 60; ++steps) Steps(*world, 1);
      ASSERT_LT(steps, 60) << "it is never hit";
      for (const EntityId id : tower) {
        if (id != tower.front()) fastest[sleeps] = std::max(fastest[sleeps], VelocityOf(*world, id).z());
      }
    }
    EXPECT_LE(fastest[true], fastest[false] + 0.01 * kSpeed) << "hit at " << side;
  }
}

}  // namespace
}  // namespace genphys::testing

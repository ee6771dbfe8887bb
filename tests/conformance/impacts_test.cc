// Impacts happen when they happen, and not at the end of a step: heights, speeds and momenta after them are compared
// with Newton's law of restitution and closed forms.
#include <cmath>
#include <numbers>
#include <random>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Impacts, Claim::kContacts, Claim::kRestitution);

constexpr double kGravity = 9.81;
// Of numbers of some ten.
constexpr double kRounding = 10 * kRounded;

std::unique_ptr<World> WorldOf(const std::string& engine, double step_size, const Vector3& gravity) {
  WorldDesc desc{.engine = engine, .gravity = gravity};
  desc.stepper.step_size = step_size;
  desc.default_auto_disable.enabled = false;
  desc.default_material.restitution_mixing = Mixing::kMaximum;
  return testing::MakeWorld(desc);
}

// m: how deep the impact after a fall by a metre may be found.
double DepthAfterAMetre(const World& world) { return ImpactDepth(std::sqrt(2 * kGravity), SubstepOf(world)); }

EntityDesc Bouncing(EntityDesc desc, double restitution) {
  desc.rigid_body->geometries[0].material.restitution = restitution;
  return desc;
}

// The highest that its centre could get from where it is now, above `floor`.
double Apex(const World& world, EntityId id, double floor) {
  return PositionOf(world, id).z() - floor + std::pow(VelocityOf(world, id).z(), 2) / (2 * kGravity);
}

TEST_P(Impacts, LeaveTheSquareOfTheRestitutionOfAHeight) {
  const std::pair<const char*, EntityDesc> bodies[] = {
      {"ball", Ball({0, 0, 1.3}, 0.3)},
      {"flat box", Body(Box{{0.3, 0.2, 0.3}}, {0, 0, 1.3})},
      {"lying capsule", Body(Capsule{0.3, 0.4}, {0, 0, 1.3})},
      {"standing cylinder", Body(Cylinder{0.3, 0.3}, {0, 0, 1.3})},
  };
  for (const auto& [name, body] : bodies) {
    for (const double restitution : {0.35, 0.8, 1.0}) {
      for (const double step_size : {1.0 / 60, 1.0 / 137, 1.0 / 1000}) {
        const auto world = WorldOf(GetParam(), step_size, {0, 0, -kGravity});
        EntityDesc desc = Bouncing(body, restitution);
        if (std::string(name) == "lying capsule") {
          desc.pose.orientation = Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
        }
        const EntityId id = Add(*world, desc);
        // It falls for 0.45 s, and after that it is in the air for at least 0.3 s.
        Steps(*world, static_cast<int>(0.6 / step_size));
        const double wanted = restitution * restitution;
        // From a depth d it falls by 1 + d and rises by the square of that from there: to less by (1 - e^2) d.
        EXPECT_NEAR(Apex(*world, id, 0.3), wanted, 2 * (1 - wanted) * DepthAfterAMetre(*world) + kRounding)
            << name << ", restitution " << restitution << ", step " << step_size;
      }
    }
  }
}

TEST_P(Impacts, KeepTheEnergyOfAnElasticBall) {
  const auto world = WorldOf(GetParam(), 1.0 / 60, {0, 0, -kGravity});
  const EntityId ball = Add(*world, Bouncing(Ball({0, 0, 1.7}, 0.2), 1));
  for (int i = 0; i < 600; ++i) {
    Steps(*world, 1);
    ASSERT_NEAR(Apex(*world, ball, 0.2), 1.5, kRounding) << "step " << i;
  }
}

TEST_P(Impacts, ExchangeTheMomentumOfTwoBalls) {
  std::mt19937 dice(7);
  std::uniform_real_distribution<double> mass(0.1, 10), speed(0.5, 8), part(0, 1);
  for (int i = 0; i < 20; ++i) {
    const double m1 = mass(dice), m2 = mass(dice), v = speed(dice), e = part(dice);
    const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
    EntityDesc first = Bouncing(Ball({0, 0, 5}, 0.3, m1), e);
    first.rigid_body->linear_velocity = {v, 0, 0};
    const EntityId moving = Add(*world, first), resting = Add(*world, Bouncing(Ball({1, 0, 5}, 0.3, m2), e));
    Steps(*world, static_cast<int>(60 * 0.8 / v));
    EXPECT_NEAR(VelocityOf(*world, moving).x(), v * (m1 - e * m2) / (m1 + m2), kRounding * v) << "case " << i;
    EXPECT_NEAR(VelocityOf(*world, resting).x(), v * m1 * (1 + e) / (m1 + m2), kRounding * v) << "case " << i;
  }
}

// Neither is anywhere near the other at the beginning or the end of a substep.
TEST_P(Impacts, AreNotMissedByThoseWhoGraze) {
  constexpr double kRadius = 0.05, kSpeed = 60;
  for (const double beside : {0.0, 0.03, 0.06, 0.09, 0.097, 0.103}) {
    const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
    EntityDesc ball = Bouncing(Ball({0, 0, 5}, kRadius), 1);
    ball.rigid_body->geometries[0].material.friction = 0;
    ball.rigid_body->linear_velocity = {kSpeed, 0, 0};
    const EntityId moving = Add(*world, ball);
    ball.pose.position = {0.25, beside, 5};
    ball.rigid_body->linear_velocity.setZero();
    const EntityId resting = Add(*world, ball);
    Steps(*world, 2);
    // Along the line of the centres they exchange their velocities.
    Vector3 passed = Vector3::Zero();
    double turned = 0;  // rad, by which that line is off where the impact is found too deep
    if (beside < 2 * kRadius) {
      const double sine = beside / (2 * kRadius), cosine = std::sqrt(1 - sine * sine);
      passed = kSpeed * cosine * Vector3(cosine, sine, 0);
      turned = ImpactDepth(kSpeed, SubstepOf(*world)) / (2 * kRadius) * sine / cosine;
    }
    EXPECT_LE((VelocityOf(*world, resting) - passed).norm(), (2 * turned + kRounding) * kSpeed) << beside;
    EXPECT_LE((VelocityOf(*world, moving) + VelocityOf(*world, resting) - Vector3(kSpeed, 0, 0)).norm(),
              kRounding * kSpeed)
        << beside;
  }
}

// They close far more slowly at the end of a substep than where they touch, in which they cover a fifth of the distance
// of their centres.
TEST_P(Impacts, OfThoseWhoGrazeHappenWhereTheyTouch) {
  constexpr double kSpeed = 4, kDistance = 0.6;
  for (const double degrees : {60.0, 75.0, 80.0, 83.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Vector3 velocity = kSpeed * Vector3(std::sin(angle), 0, std::cos(angle));
    for (int phase = 0; phase < 10; ++phase) {
      const auto world = WorldOf(GetParam(), 1.0 / 30, Vector3::Zero());
      EntityDesc ball = Bouncing(Ball({0, 0, 5 + kDistance}, 0.2), 0.5);
      ball.rigid_body->geometries[0].material.friction = 0;
      const EntityId resting = Add(*world, ball);
      ball.rigid_body->geometries[0].shape = Sphere{0.4};
      ball.pose.position = Vector3(0, 0, 5) - (6 + phase / 10.0) / 30 * velocity;
      ball.rigid_body->linear_velocity = velocity;
      Add(*world, ball);
      Steps(*world, 9);
      const Vector3 passed(0, 0, 0.75 * velocity.z());
      // The line of the centres is off by more than the depth at which they meet, for they slip past each other.
      const double turned = ImpactDepth(kSpeed, SubstepOf(*world)) / kDistance * std::tan(angle);
      EXPECT_LE((VelocityOf(*world, resting) - passed).norm(), (2 * turned + kRounding) * kSpeed)
          << degrees << " degrees, phase " << phase;
    }
  }
}

// At the end of the step the second ball lies in the third, and the first in the second. It would have hit that first,
// so that their impact waits for its own; but it is hit from aside before, and flies past.
TEST_P(Impacts, HappenThatHadToWaitForWhatDidNot) {
  constexpr double kStepSize = 0.1, kAside = 50;
  const auto world = WorldOf(GetParam(), kStepSize, Vector3::Zero());
  Do(*world, SetStepper{{.step_size = kStepSize, .substeps = 1}});
  const auto add = [&](const Vector3& position, const Vector3& velocity) {
    EntityDesc ball = Bouncing(Ball(position, 0.5), 1);
    ball.rigid_body->geometries[0].material.friction = 0;
    ball.rigid_body->linear_velocity = velocity;
    return Add(*world, ball);
  };
  const EntityId first = add({-1.6, 0, 5}, {20, 0, 0}), second = add({0, 0, 5}, {10, 0, 0});
  const EntityId third = add({1.8, 0, 5}, {0, 0, 0}), aside = add({-1.6, -2.5, 5}, {20, kAside, 0});

  Steps(*world, 1);

  const double late = 2 * ImpactDepth(kAside, kStepSize);  // m
  EXPECT_LE((VelocityOf(*world, first) - Vector3(20, kAside, 0)).norm(), late * kAside);
  EXPECT_LE((VelocityOf(*world, aside) - Vector3(20, 0, 0)).norm(), late * kAside);
  EXPECT_LE(VelocityOf(*world, second).norm(), kRounding);
  EXPECT_LE((VelocityOf(*world, third) - Vector3(10, 0, 0)).norm(), kRounding);
  EXPECT_LE((PositionOf(*world, second) - Vector3(0.8, 0, 5)).norm(), late);
  EXPECT_LE((PositionOf(*world, third) - Vector3(2, 0, 5)).norm(), late);
}

TEST_P(Impacts, PassThroughACradle) {
  for (const double gap : {0.0, 1e-3}) {
    const auto world = WorldOf(GetParam(), 1.0 / 240, Vector3::Zero());
    std::vector<EntityId> balls;
    for (int i = 0; i < 5; ++i) {
      EntityDesc ball = Bouncing(Ball({i * (0.2 + gap) + (i > 0 ? 0.5 : 0), 0, 5}, 0.1), 1);
      if (i == 0) ball.rigid_body->linear_velocity = {2, 0, 0};
      balls.push_back(Add(*world, ball));
    }
    Steps(*world, 240);
    for (size_t i = 0; i < 5; ++i) {
      EXPECT_NEAR(VelocityOf(*world, balls[i]).x(), i == 4 ? 2 : 0, kRounding) << "ball " << i << ", gap " << gap;
    }
  }
}

TEST_P(Impacts, LandOnTheFloorAndNotInIt) {
  for (const double height : {0.02, 0.7, 4.0}) {
    const auto world = WorldOf(GetParam(), 1.0 / 60, {0, 0, -kGravity});
    const double depth = 2 * ImpactDepth(std::sqrt(2 * kGravity * height), SubstepOf(*world));
    const EntityId crate = Add(*world, Crate({0, 0, 0.5 + height}, 0.5));
    for (int i = 0; i < 120; ++i) {
      Steps(*world, 1);
      ASSERT_GT(PositionOf(*world, crate).z(), 0.5 - depth) << "step " << i << " from " << height;
    }
    EXPECT_NEAR(PositionOf(*world, crate).z(), 0.5, kTouch);
    EXPECT_LT(VelocityOf(*world, crate).norm(), SweptSpeed(kGravity, SubstepOf(*world)));
  }
}

TEST_P(Impacts, StopABulletAtAThinWall) {
  for (const double speed : {3.0, 47.0, 300.0}) {
    for (const double restitution : {0.0, 0.6}) {
      const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
      Add(*world, Block({1, 0, 5}, {0.01, 2, 2}));
      EntityDesc ball = Bouncing(Ball({0.13, 0.2, 5.1}, 0.05), restitution);
      ball.rigid_body->linear_velocity = {speed, 0, 0};
      const EntityId bullet = Add(*world, ball);
      for (int i = 0; i < 40; ++i) {
        Steps(*world, 1);
        ASSERT_LT(PositionOf(*world, bullet).x(), 0.94 + 2 * ImpactDepth(speed, SubstepOf(*world)))
            << speed << " m/s, step " << i;
      }
      EXPECT_NEAR(VelocityOf(*world, bullet).x(), -restitution * speed, kDirect * speed) << speed << " m/s";
    }
  }
}

// The next tile is behind the one that is hit, but what comes askew is as far from its edge as from anything that it
// meets at the same time.
TEST_P(Impacts, OnAWallOfTilesAreThoseOnAWhole) {
  Proves({Claim::kBox});
  constexpr double kRadius = 0.05, kHalfTile = 0.11, kWall = 2;
  for (const double speed : {3.0, 47.0, 300.0}) {
    for (const double angle : {0.0, 0.3, 0.8}) {
      for (int i = 0; i < 8; ++i) {
        const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
        EntityDesc wall = Block({kWall, 0, 5}, {0.01, kHalfTile, kHalfTile});
        const Geometry tile = wall.rigid_body->geometries[0];
        for (int y = -5; y <= 5; ++y) {
          for (int z = -5; z <= 5; ++z) {
            if (y == 0 && z == 0) continue;
            wall.rigid_body->geometries.push_back(tile);
            wall.rigid_body->geometries.back().pose_in_entity.position = {0, 2 * kHalfTile * y, 2 * kHalfTile * z};
          }
        }
        Add(*world, wall);
        // From one tile across the seam to the next, and once in the middle of one.
        const Vector3 hit(kWall - 0.01 - kRadius, kHalfTile + 0.012 * (i - 3), 5 + 0.03 * i);
        const Vector3 velocity = speed * Vector3(std::cos(angle), std::sin(angle), 0);
        EntityDesc ball = Bouncing(Ball(hit - 0.012 * velocity, kRadius), 0.7);
        ball.rigid_body->linear_velocity = velocity;
        ball.rigid_body->geometries[0].material.friction = 0;
        const EntityId bullet = Add(*world, ball);
        Steps(*world, 2);
        const Vector3 thrown_back(-0.7 * velocity.x(), velocity.y(), 0);
        // On the seam itself it goes past by as deep as it is found, and the edge is tilted by that.
        const double tilt = std::tan(angle) * ImpactDepth(speed, SubstepOf(*world)) / kRadius;
        EXPECT_LT((VelocityOf(*world, bullet) - thrown_back).norm(), (kDirect + 2 * tilt) * speed)
            << speed << " m/s, " << angle << " rad, beside the seam by " << hit.y() - kHalfTile << " m";
      }
    }
  }
}

TEST_P(Impacts, StopEveryBulletOfAHail) {
  // Swarms that fly side by side, so that those who are fast have neighbours whom they do not meet: what they may pass
  // is looked for in another way than for a single one.
  const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
  Add(*world, Block({4, 0, 5}, {0.01, 2, 2}));
  std::vector<std::pair<EntityId, double>> bullets;
  for (int i = 0; i < 60; ++i) {
    const double speed = 20.0 + 4 * (i % 10);
    EntityDesc ball = Bouncing(Ball({0.01 * i, 0.11 * (i % 10), 5 + 0.11 * (i / 10)}, 0.05), 1);
    ball.rigid_body->linear_velocity = {speed, 0, 0};
    bullets.emplace_back(Add(*world, ball), speed);
  }
  Steps(*world, 30);
  for (const auto& [bullet, speed] : bullets) {
    EXPECT_LT(PositionOf(*world, bullet).x(), 3.94);
    EXPECT_NEAR(VelocityOf(*world, bullet).x(), -speed, kDirect * speed);
  }
}

// A wall that moves is hit by one after the other, so that the later ones wait for what the first does to it.
TEST_P(Impacts, StopAllThatMeetAWallThatMovesInOneStep) {
  constexpr double kWallMass = 1e7;
  // m/s: twice what the three of them give to it, 30 N*s each.
  constexpr double kGiven = 2 * 3 * 30 / kWallMass;
  for (const double wall_speed : {-10.0, -1.0, 0.0}) {
    for (int phase = 0; phase < 12; ++phase) {
      SCOPED_TRACE(phase);
      const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
      EntityDesc slab = Body(Box{{0.01, 5, 5}}, {3, 0, 5}, kWallMass);
      // At rest it is one that can be pushed, but hardly.
      if (wall_speed != 0) slab.rigid_body->motion_type = MotionType::kKinematic;
      slab.rigid_body->linear_velocity = {wall_speed, 0, 0};
      const EntityId wall = Add(*world, Bouncing(slab, 0.5));
      std::vector<EntityId> balls;
      for (int i = 0; i < 3; ++i) {
        EntityDesc ball = Bouncing(Ball({0.03 * phase - 0.013 * i, 2.0 * i - 2, 5.3}, 0.05), 0.5);
        ball.rigid_body->linear_velocity = {20, 0, 0};
        balls.push_back(Add(*world, ball));
      }
      Steps(*world, 14);
      for (const EntityId ball : balls) {
        EXPECT_LT(PositionOf(*world, ball).x(), PositionOf(*world, wall).x() - 0.06 + ImpactDepth(30, 1.0 / 60))
            << "wall at " << wall_speed << " m/s";
        EXPECT_NEAR(VelocityOf(*world, ball).x(), wall_speed - 0.5 * (20 - wall_speed), kGiven)
            << "wall at " << wall_speed << " m/s";
      }
    }
  }
}

// A paddle that is faster than they are finds them, and not they the paddle.
TEST_P(Impacts, OfAPaddleTakeAllThatLieInItsWayAlong) {
  for (int phase = 0; phase < 12; ++phase) {
    SCOPED_TRACE(phase);
    const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
    EntityDesc slab = Body(Box{{0.01, 5, 5}}, {0.03 * phase, 0, 5});
    slab.rigid_body->motion_type = MotionType::kKinematic;
    slab.rigid_body->linear_velocity = {40, 0, 0};
    const EntityId paddle = Add(*world, Bouncing(slab, 0.5));
    std::vector<EntityId> balls;
    for (int i = 0; i < 4; ++i)
      balls.push_back(Add(*world, Bouncing(Ball({1.5 + 0.1 * i, 2.0 * i - 3, 5}, 0.05), 0.5)));
    Steps(*world, 6);
    for (const EntityId ball : balls) {
      EXPECT_GT(PositionOf(*world, ball).x(), PositionOf(*world, paddle).x());
      EXPECT_NEAR(VelocityOf(*world, ball).x(), 60, 10 * kRounding);
    }
  }
}

TEST_P(Impacts, StopThoseThatOverlapAtAThinWall) {
  for (const double apart : {0.0999, 0.09, 0.06}) {
    for (const double speed : {7.5, 20.0, 200.0}) {
      for (const double behind : {0.0, 0.003, 0.02}) {
        const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
        Add(*world, Block({1, 0, 5}, {0.01, 5, 5}));
        std::vector<EntityId> balls;
        for (int i = 0; i < 2; ++i) {
          EntityDesc ball = Bouncing(Ball({-behind * i, apart * i, 5}, 0.05), 0);
          ball.rigid_body->linear_velocity = {speed, 0, 0};
          balls.push_back(Add(*world, ball));
        }
        for (int i = 0; i < 12 + 72 / speed; ++i) {
          Steps(*world, 1);
          for (const EntityId ball : balls) {
            ASSERT_LT(PositionOf(*world, ball).x(), 1) << speed << " m/s, " << apart << " m apart, step " << i;
          }
        }
      }
    }
  }
}

TEST_P(Impacts, GiveABulletsMomentumToAFreePlate) {
  const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
  const EntityId plate = Add(*world, Body(Box{{0.01, 0.5, 0.5}}, {1, 0, 5}, 2));
  EntityDesc ball = Bouncing(Ball({0.1, 0, 5}, 0.05, 0.5), 0.5);
  ball.rigid_body->linear_velocity = {120, 0, 0};
  const EntityId bullet = Add(*world, ball);
  Steps(*world, 4);
  const double momentum = 0.5 * VelocityOf(*world, bullet).x() + 2 * VelocityOf(*world, plate).x();
  EXPECT_NEAR(momentum, 60, 60 * kRounded);
  EXPECT_NEAR(VelocityOf(*world, plate).x() - VelocityOf(*world, bullet).x(), 60, 60 * kRounding);
}

TEST_P(Impacts, AreToldWithTheImpulseThatPassed) {
  const auto world = WorldOf(GetParam(), 1.0 / 60, {0, 0, -kGravity});
  Add(*world, Bouncing(Ball({0, 0, 1.5}, 0.5, 3), 0.4));
  Steps(*world, 1);
  world->TakeEvents();
  Steps(*world, 35);
  const auto began = Of<ContactBegan>(world->TakeEvents());
  ASSERT_EQ(began.size(), 1u);
  ASSERT_EQ(began[0].points.size(), 1u);
  const double speed = std::sqrt(2 * kGravity);
  // Relative, of the speed of a fall by one metre and so much more: a half of that.
  const double faster = DepthAfterAMetre(*world) / 2;
  EXPECT_NEAR(began[0].points[0].normal_impulse, 3 * 1.4 * speed, 2 * faster * 3 * 1.4 * speed);
  EXPECT_NEAR(began[0].points[0].relative_velocity.z(), -speed, 2 * faster * speed);
}

// What stands on something passes on in a second blow what it could not bear in the first.
TEST_P(Impacts, AreToldWithTheVelocityBeforeTheFirstOfThem) {
  for (const double mass : {1.0, 30.0, 500.0}) {
    const auto world = MakeWorld();
    const EntityId crate = Add(*world, Crate({0, 0, 0.5}));
    const EntityId ball = Add(*world, Ball({0.2, 0.1, 2.5}, 0.5, mass));
    Steps(*world, 1);
    world->TakeEvents();
    Vector3 before = VelocityOf(*world, ball);
    std::vector<ContactBegan> began;
    for (int step = 0; step < 60 && began.empty(); ++step) {
      before = VelocityOf(*world, ball);
      Steps(*world, 1);
      for (const ContactBegan& each : Of<ContactBegan>(world->TakeEvents())) {
        if (each.pair == EntityPair{crate, ball}) began.push_back(each);
      }
    }
    ASSERT_EQ(began.size(), 1u);
    ASSERT_FALSE(began[0].points.empty());
    // It fell on for a step at most.
    const double told = began[0].points[0].relative_velocity.z(), gained = kGravity / 60;
    EXPECT_LE(told, before.z() + 1e-6) << mass << " kg";
    EXPECT_GE(told, before.z() - gained - 1e-6) << mass << " kg";
  }
}

TEST_P(Impacts, TakeTheSpeedOfWhatIsMovedByCommand) {
  const auto world = WorldOf(GetParam(), 1.0 / 60, Vector3::Zero());
  EntityDesc bat = Block({0, 0, 5}, {0.1, 1, 1});
  bat.rigid_body->motion_type = MotionType::kKinematic;
  bat.rigid_body->linear_velocity = {2, 0, 0};
  Add(*world, bat);
  const EntityId ball = Add(*world, Bouncing(Ball({1, 0, 5}, 0.3), 0.7));
  Steps(*world, 60);
  EXPECT_NEAR(VelocityOf(*world, ball).x(), 2 * 1.7, kRounding);
}

}  // namespace
}  // namespace genphys::testing

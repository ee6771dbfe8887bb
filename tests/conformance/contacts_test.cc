// What touches, what slides, what bounces and what only looks: alike on every engine.
#include <cmath>
#include <numbers>

#include "conformance/engine_test.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Contacts, Claim::kContacts);

constexpr double kGravity = 9.81;

TEST_P(Contacts, EveryShapeRestsOnTheFloorAtItsHeight) {
  Proves({Claim::kSphere, Claim::kBox, Claim::kCylinder, Claim::kCapsule, Claim::kPlane});
  const std::vector<std::pair<Shape, double>> shapes = {
      {Sphere{0.4}, 0.4}, {Box{{0.3, 0.4, 0.2}}, 0.2}, {Cylinder{0.4, 0.3}, 0.3}, {Capsule{0.2, 0.3}, 0.2}};
  for (const auto& [shape, height] : shapes) {
    const auto world = MakeWorld();
    EntityDesc body = Body(shape, {0, 0, height + 0.05});
    if (std::holds_alternative<Capsule>(shape)) {
      body.pose.orientation = Quaternion(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()));
    }
    const EntityId id = Add(*world, body);

    Steps(*world, 180);

    EXPECT_NEAR(PositionOf(*world, id).z(), height, kTouch) << "shape " << shape.index();
  }
}

TEST_P(Contacts, PointFromTheSmallerIdToTheLarger) {
  Proves({Claim::kContactEvents});
  const auto world = MakeWorld();
  Add(*world, Crate({0, 0, 0.55}));
  Steps(*world, 1);
  world->TakeEvents();
  Steps(*world, 30);

  const auto began = Of<ContactBegan>(world->TakeEvents());

  ASSERT_EQ(began.size(), 1u);
  EXPECT_LT(began[0].pair.a, began[0].pair.b);
  ASSERT_GE(began[0].points.size(), 3u);
  for (const EventContactPoint& point : began[0].points) {
    EXPECT_NEAR(point.normal.z(), 1, kRounded);
    EXPECT_NEAR(point.position.z(), 0, kContactGapMax) << "as far ahead as points are told";
    EXPECT_LT(point.relative_velocity.z(), 0) << "it was still falling";
    EXPECT_DOUBLE_EQ(point.friction, 0.5);
  }
}

TEST_P(Contacts, CarryTheWeight) {
  Proves({Claim::kContactImpulses});
  WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}};
  desc.recorded_events.persisting_contacts = true;
  const auto world = testing::MakeWorld(desc);
  EntityDesc crate = Crate({0, 0, 0.5}, 0.5, 3);
  crate.rigid_body->auto_disable.enabled = false;
  Add(*world, crate);
  Steps(*world, 120);
  world->TakeEvents();

  Steps(*world, 60);

  double impulse = 0;
  for (const ContactPersisted& contact : Of<ContactPersisted>(world->TakeEvents())) {
    for (const EventContactPoint& point : contact.points) impulse += point.normal_impulse;
  }
  EXPECT_NEAR(impulse / (3 * kGravity * 1.0), 1, kSwept);
}

TEST_P(Contacts, SlidingStopsWhereCoulombSays) {
  Proves({Claim::kKineticFriction});
  // v^2 / (2 mu g), along an axis and along a diagonal.
  constexpr double kSpeed = 3, kFriction = 0.3;
  const double distance = kSpeed * kSpeed / (2 * kFriction * kGravity);
  for (const double heading : {0.0, M_PI / 4}) {
    const auto world = MakeWorld();
    EntityDesc box = Body(Box{{0.2, 0.2, 0.05}}, {0, 0, 0.05});
    box.rigid_body->geometries[0].material.friction = kFriction * kFriction / 0.5;  // mixes to kFriction with the floor
    box.rigid_body->linear_velocity = kSpeed * Vector3(std::cos(heading), std::sin(heading), 0);
    const EntityId id = Add(*world, box);

    Steps(*world, 120);

    const Vector3 position = PositionOf(*world, id);
    EXPECT_NEAR(position.head<2>().norm(), distance, 2 * StopError(kFriction * kGravity, SubstepOf(*world)))
        << "heading " << heading;
    EXPECT_NEAR(std::atan2(position.y(), position.x()), heading, 2 * kSwept) << "what sweeps leave across the way";
  }
}

TEST_P(Contacts, TellOfAllFrictionThatStopsABox) {
  Proves({Claim::kContactImpulses, Claim::kKineticFriction});
  constexpr double kMass = 3, kSpeed = 0.3, kFriction = 0.5;
  for (const uint32_t substeps : {1u, 2u, 4u, 8u}) {
    WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}, .stepper = {.substeps = substeps}};
    desc.recorded_events.persisting_contacts = true;
    const auto world = testing::MakeWorld(desc);
    EntityDesc crate = Body(Box{{0.2, 0.2, 0.05}}, {0, 0, 0.05}, kMass);
    crate.rigid_body->linear_velocity = {kSpeed, 0, 0};
    Add(*world, crate);
    Vector3 told = Vector3::Zero();
    for (int i = 0; i < 12; ++i) {
      Steps(*world, 1);
      const auto add = [&](const std::vector<EventContactPoint>& points) {
        for (const EventContactPoint& point : points) told += point.friction_impulse;
      };
      const std::vector<Event> events = world->TakeEvents();
      for (const ContactBegan& began : Of<ContactBegan>(events)) add(began.points);
      for (const ContactPersisted& persisted : Of<ContactPersisted>(events)) add(persisted.points);
    }
    // A solve is for the time from the middle of a substep to that of the next one.
    const double late = kFriction * kMass * kGravity * SubstepOf(*world);
    EXPECT_NEAR(told.x(), -kMass * kSpeed, late) << substeps;
    EXPECT_NEAR(told.y(), 0, kDirect * kMass * kSpeed) << substeps;
  }
}

TEST_P(Contacts, KineticFrictionBrakesAndStaticFrictionHolds) {
  Proves({Claim::kKineticFriction, Claim::kStaticFriction});
  const auto world = MakeWorld();
  Do(*world, SetGravity{{kGravity * 0.6, 0, -kGravity}});  // a slope of tan = 0.6
  const auto box = [&](double y, double speed) {
    EntityDesc desc = Body(Box{{0.2, 0.2, 0.05}}, {0, y, 0.05});
    desc.rigid_body->geometries[0].material.friction = 2.0;           // mixes with the floor to 1.0
    desc.rigid_body->geometries[0].material.kinetic_friction = 0.08;  // mixes with the floor to 0.2
    desc.rigid_body->linear_velocity.x() = speed;
    desc.rigid_body->auto_disable.enabled = false;
    return Add(*world, desc);
  };
  const EntityId holds = box(0, 0), slides = box(5, 1);

  Steps(*world, 60);

  EXPECT_NEAR(PositionOf(*world, holds).x(), 0, 2 * SweptSpeed(0.6 * kGravity, SubstepOf(*world)) * 1);
  // Slope less kinetic friction: 0.4 g, from 1 m/s, for one second; of the friction sweeps may leave a part.
  EXPECT_NEAR(PositionOf(*world, slides).x(), 1 + 0.2 * kGravity, 2 * kSwept * 0.2 * kGravity / 2);
}

// A corner that carried nothing may have to carry something at the next step.
TEST_P(Contacts, ABlockOnASlopeThatIsAHundredthLessSteepThanFrictionDoesNotCreep) {
  Proves({Claim::kStaticFriction, Claim::kBox});
  constexpr double kStep = 1.0 / 240;
  constexpr double kCreepMax = 1e-6;  // m/s, which is promised
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double friction = random.Uniform(0.1, 1.2), angle = std::atan(0.99 * friction);
    const double heading = random.Uniform(0, 2 * std::numbers::pi);
    const Vector3 down(std::cos(heading), std::sin(heading), 0);
    WorldDesc desc{.engine = GetParam(),
                   .gravity = kGravity * (std::sin(angle) * down - std::cos(angle) * Vector3::UnitZ()),
                   .stepper = {.step_size = kStep}};
    desc.default_material.friction = friction;
    desc.default_auto_disable.enabled = false;
    const auto world = testing::MakeWorld(desc);
    const double x = random.LogUniform(0.05, 0.5), y = random.LogUniform(0.05, 0.5), z = std::min(x, y) / 4;
    EntityDesc box = Body(Box{{x, y, z}}, {0, 0, z}, random.LogUniform(0.01, 100));
    box.pose.orientation = Quaternion(Eigen::AngleAxisd(random.Uniform(-1, 1), Vector3::UnitZ()));
    const EntityId block = Add(*world, box);

    Steps(*world, 240);
    const Vector3 middle = PositionOf(*world, block);
    Steps(*world, 240);

    EXPECT_LE((PositionOf(*world, block) - middle).norm(), kCreepMax);
  }
}

// However little it weighs and however smooth it is, whatever way the slope goes.
TEST_P(Contacts, ABlockOnASlopeThatIsAHundredthSteeperThanFrictionSlips) {
  Proves({Claim::kStaticFriction, Claim::kBox});
  constexpr double kPromised = 1e-3;  // of its acceleration
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double gravity = random.LogUniform(0.1, 30), friction = random.LogUniform(0.01, 1);
    const double angle = std::atan(1.01 * friction), heading = random.Uniform(0, 2 * std::numbers::pi);
    const Vector3 down(std::cos(heading), std::sin(heading), 0);
    WorldDesc desc{.engine = GetParam(),
                   .gravity = gravity * (std::sin(angle) * down - std::cos(angle) * Vector3::UnitZ())};
    desc.default_material.friction = friction;
    desc.default_auto_disable.enabled = false;
    const auto world = testing::MakeWorld(desc);
    const EntityId block = Add(*world, Body(Box{{0.3, 0.3, 0.1}}, {0, 0, 0.1}));

    Steps(*world, 60);

    // From the speed at which it counts as sliding nothing changes, for both coefficients are the same.
    const double wanted = gravity * (std::sin(angle) - friction * std::cos(angle));
    EXPECT_NEAR(VelocityOf(*world, block).dot(down), wanted, kPromised * wanted) << gravity << " m/s^2, " << friction;
  }
}

// Sides that are parallel but for rounding, and not along the axes of the world.
TEST_P(Contacts, ABoxLiesOnATiltedBoxWhateverSidesAreParallel) {
  Proves({Claim::kStaticFriction, Claim::kBox});
  constexpr double kMovedMax = 1e-6;  // m
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    WorldDesc desc{.engine = GetParam(), .gravity = -kGravity * Vector3::UnitZ()};
    desc.default_material.friction = 1;
    desc.default_auto_disable.enabled = false;
    const auto world = testing::MakeWorld(desc);
    const Vector3 middle(0, 0, 10);
    const Quaternion tilt(Eigen::AngleAxisd(random.Uniform(0.02, 0.6), Vector3::UnitY()));
    const Quaternion turn(Eigen::AngleAxisd(std::numbers::pi / 2 * static_cast<double>(seed % 4), Vector3::UnitZ()));
    EntityDesc slope = Block(middle + tilt * Vector3(0, 0, -0.5), {2, 2, 0.5});
    slope.pose.orientation = tilt;
    Add(*world, slope);
    const Vector3 half(random.Uniform(0.05, 0.3), random.Uniform(0.05, 0.3), random.Uniform(0.02, 0.1));
    const Vector3 place(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), half.z());
    EntityDesc box = Body(Box{half}, middle + tilt * place);
    box.pose.orientation = tilt * turn;
    const EntityId lies = Add(*world, box);

    Steps(*world, 60);

    EXPECT_LE((PositionOf(*world, lies) - box.pose.position).norm(), kMovedMax);
  }
}

// Not quite: it rolls aside, and friction that holds it does not make it roll more.
TEST_P(Contacts, ACapsuleThatLiesDownASlopeHolds) {
  Proves({Claim::kStaticFriction, Claim::kCapsule});
  constexpr double kStep = 1.0 / 240, kSlope = 0.38, kAside = 1e-4, kRadius = 0.01, kHalf = 0.05, kMovedMax = 1e-6;
  WorldDesc desc{.engine = GetParam(),
                 .gravity = kGravity * Vector3(std::sin(kSlope), 0, -std::cos(kSlope)),
                 .stepper = {.step_size = kStep}};
  desc.default_material.friction = 0.7;
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  EntityDesc capsule = Body(Capsule{kRadius, kHalf}, {0, 0, kRadius});
  capsule.pose.orientation =
      Eigen::AngleAxisd(kAside, Vector3::UnitZ()) * Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY());
  const EntityId lies = Add(*world, capsule);

  Steps(*world, 240);

  const Vector3 aside(std::sin(kAside), -std::cos(kAside), 0);
  const Vector3 moved = PositionOf(*world, lies) - capsule.pose.position;
  EXPECT_LE((moved - moved.dot(aside) * aside).norm(), kMovedMax);
  // As fast as the lightest and the heaviest thing of that radius would roll, a point and a hoop.
  const double fall = kGravity * std::sin(kSlope) * std::sin(kAside) / 2;
  EXPECT_LE(std::abs(moved.dot(aside)), fall);
  EXPECT_GE(std::abs(moved.dot(aside)), fall / 2);
}

TEST_P(Contacts, ABallBouncesAsHighAsItsRestitution) {
  Proves({Claim::kRestitution, Claim::kSphere});
  constexpr double kStep = 1.0 / 240, kFall = 2;
  WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}, .stepper = {.step_size = kStep}};
  desc.default_material.restitution = 0.8;
  const auto world = testing::MakeWorld(desc);
  const EntityId ball = Add(*world, Ball({0, 0, 2.5}));

  double highest = 0;
  bool has_bounced = false;
  for (int i = 0; i < 360; ++i) {
    Steps(*world, 1);
    has_bounced |= VelocityOf(*world, ball).z() > 0;
    if (has_bounced) highest = std::max(highest, PositionOf(*world, ball).z());
  }

  const double found = ImpactDepth(std::sqrt(2 * kGravity * kFall), SubstepOf(*world));
  EXPECT_NEAR(highest, 0.5 + 0.64 * kFall, 2 * (ApexMissed(kGravity, kStep) + found));
}

TEST_P(Contacts, ASensorTellsOfAVisitorAndPushesNothing) {
  Proves({Claim::kSensors, Claim::kSensorEvents});
  const auto world = MakeWorld();
  EntityDesc gate = Block({0, 0, 5}, {1, 1, 0.5});
  gate.rigid_body->geometries[0].is_sensor = true;
  const EntityId sensor = Add(*world, gate), ball = Add(*world, Ball({0, 0, 8}));
  const EntityId reference = Add(*world, Ball({20, 0, 8}));
  world->TakeEvents();

  Steps(*world, 70);

  EXPECT_NEAR(PositionOf(*world, ball).z(), PositionOf(*world, reference).z(), kRounded);
  const std::vector<Event> events = world->TakeEvents();
  const auto entered = Of<SensorEntered>(events);
  const auto left = Of<SensorLeft>(events);
  ASSERT_EQ(entered.size(), 1u);
  EXPECT_EQ(entered[0].sensor, sensor);
  EXPECT_EQ(entered[0].visitor, ball);
  EXPECT_EQ(left.size(), 1u);
}

TEST_P(Contacts, FilteredPairsPassThroughEachOther) {
  Proves({Claim::kCategories});
  const auto world = MakeWorld();
  EntityDesc ghost = Ball({0, 0, 2});
  ghost.rigid_body->geometries[0].collides_with_bits = 2;
  const EntityId id = Add(*world, ghost);

  Steps(*world, 120);

  EXPECT_LT(PositionOf(*world, id).z(), -5);
}

TEST_P(Contacts, RaysHitTheNearestSurface) {
  Proves({Claim::kRayCasts});
  const auto world = MakeWorld();
  const EntityId ball = Add(*world, Ball({3, 0, 1})), block = Add(*world, Block({6, 0, 1}, {0.5, 2, 0.9}));
  const std::vector<Ray> rays = {{{0, 0, 1}, {10, 0, 0}}, {{0, 1, 1}, {10, 0, 0}}, {{0, 0, 5}, {0, 0, 10}}};

  const Result<std::vector<RayHit>> hits = world->CastRays(rays);

  ASSERT_TRUE(hits.ok()) << hits.status();
  EXPECT_EQ((*hits)[0].entity, ball);
  EXPECT_NEAR((*hits)[0].fraction, 0.25, kRounded);
  EXPECT_NEAR((*hits)[0].normal.x(), -1, kRounded);
  EXPECT_EQ((*hits)[1].entity, block);
  EXPECT_NEAR((*hits)[1].fraction, 0.55, kRounded);
  EXPECT_TRUE((*hits)[2].entity.is_null());
}

TEST_P(Contacts, AnOffsetCompoundRestsOnItsGeometries) {
  Proves({Claim::kCompound});
  const auto world = MakeWorld();
  EntityDesc table;
  table.pose.position = {0, 0, 1.01};
  table.rigid_body = RigidBody{.geometries = {Geometry{.shape = Box{{1, 1, 0.1}}}}};
  for (const double x : {-0.8, 0.8}) {
    for (const double y : {-0.8, 0.8}) {
      Geometry leg = Block({0, 0, 0}, {0.1, 0.1, 0.4}).rigid_body->geometries.front();
      leg.pose_in_entity.position = {x, y, -0.5};
      table.rigid_body->geometries.push_back(leg);
    }
  }
  const EntityId id = Add(*world, table);

  Steps(*world, 120);

  EXPECT_NEAR(PositionOf(*world, id).z(), 0.9, kTouch);
  EXPECT_LE(FromColumn(world->state().orientations.col(id.index())).angularDistance(Quaternion::Identity()),
            2 * kTouch / 1.6)
      << "its legs are so far apart";
}

TEST_P(Contacts, ABodyThatLeavesTheWorldIsDisabledAndAnnounced) {
  Proves({Claim::kBounds, Claim::kFaultEvents});
  const auto world = MakeWorld();
  EntityDesc rocket = Ball({9.9999e6, 0, 10});
  rocket.rigid_body->linear_velocity = {1e5, 0, 0};
  const EntityId id = Add(*world, rocket), other = Add(*world, Ball({0, 0, 5}));
  world->TakeEvents();

  Steps(*world, 30);

  const auto faulted = Of<EntityFaulted>(world->TakeEvents());
  ASSERT_EQ(faulted.size(), 1u);
  EXPECT_EQ(faulted[0].id, id);
  EXPECT_LE(PositionOf(*world, id).x(), 1e7);
  EXPECT_LT(PositionOf(*world, other).z(), 5) << "the others go on";
  Do(*world, SetPose{.id = id, .position = Vector3(0, 5, 5)});
  Steps(*world, 30);
  EXPECT_LT(PositionOf(*world, id).z(), 5) << "a new pose brings it back";
}

TEST_P(Contacts, TheTouchOfABodyThatLeavesTheWorldBeginsAndEndsOnce) {
  Proves({Claim::kBounds, Claim::kContactEvents});
  for (const Quality quality : {Quality::kFast, Quality::kBalanced}) {
    for (const double way : {0.3, 1.1, 1.6, 2.2, 2.9}) {
      WorldDesc desc{.engine = GetParam(), .stepper = {.quality = quality}};
      desc.recorded_events.persisting_contacts = true;
      const auto world = testing::MakeWorld(desc);
      EntityDesc sliding = Crate({1e7 - 5 - way, 0, 0.5});
      sliding.rigid_body->linear_velocity = {100, 0, 0};
      const EntityId id = Add(*world, sliding);
      Steps(*world, 8);
      Do(*world, SetPose{.id = id, .position = Vector3(0, 0, 5)});
      Steps(*world, 3);
      bool touches = false;
      size_t faults = 0;
      for (const Event& event : world->TakeEvents()) {
        if (std::holds_alternative<EntityFaulted>(event.kind)) ++faults;
        const bool begins = std::holds_alternative<ContactBegan>(event.kind);
        if (!begins && !std::holds_alternative<ContactEnded>(event.kind)) continue;
        EXPECT_NE(touches, begins) << way << " m, at step " << event.step;
        touches = begins;
      }
      EXPECT_EQ(faults, 1u) << way;
      EXPECT_FALSE(touches) << way;
    }
  }
}

TEST_P(Contacts, ABoxSlidesOverTheSeamsOfTilesAsOverOneFloorAndStopsAtOneThatStandsOut) {
  Proves({Claim::kKineticFriction, Claim::kStaticSolid});
  constexpr double kSpeed = 3, kFriction = 0.3, kHalf = 0.25;
  const double way = kSpeed * kSpeed / (2 * kFriction * 9.81);
  for (const double turn : {0.0, 0.4}) {
    for (const double phase : {0.0, 0.1234, 0.37}) {
      for (const double step : {0.0, 0.05}) {
        WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -9.81}};
        desc.ground_plane = false;
        desc.default_material.friction = kFriction;
        const auto world = testing::MakeWorld(desc);
        Require(*world, Feature::kContacts);
        for (int i = -1; i < 6; ++i) {
          const double up = i == 2 ? step : 0;
          Add(*world, Block({2 * kHalf * i - phase, 0, -0.5 + up}, {kHalf, 2, 0.5}));
        }
        EntityDesc box = Body(Box{{0.2, 0.15, 0.1}}, {0, 0, 0.1});
        box.pose.orientation = Quaternion(Eigen::AngleAxisd(turn, Vector3::UnitZ()));
        box.rigid_body->linear_velocity = {kSpeed, 0, 0};
        const EntityId id = Add(*world, box);

        Steps(*world, 120);

        const double x = PositionOf(*world, id).x();
        if (step == 0) {
          EXPECT_NEAR(x, way, 2e-3 * way) << turn << ", " << phase;
          EXPECT_NEAR(PositionOf(*world, id).z(), 0.1, kTouch) << turn << ", " << phase;
        } else {
          EXPECT_LE(x, 2 * kHalf * 1.5 - phase + 0.01) << turn << ", " << phase;
        }
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

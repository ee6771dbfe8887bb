// Surfaces that run: conveyor belts and tracks, on every engine.
#include <cmath>

#include "engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Belts, Claim::kSurfaceVelocity);

constexpr double kGravity = 9.81, kStep = 1.0 / 60, kSpeed = 2, kFriction = 0.5;

std::unique_ptr<World> OnFloor(const std::string& engine, const Material& all = {}) {
  return MakeWorld(WorldDesc{
      .engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = kStep}, .default_material = all});
}

/// A static block, its top at z = 1, whose surface runs at `velocity` in the geometry's frame.
EntityDesc Belt(const Vector3& velocity) {
  EntityDesc belt = Block({0, 0, 0.5}, {20, 20, 0.5});
  belt.rigid_body->geometries[0].surface_velocity = velocity;
  return belt;
}

double WayError(const World& world) { return 2 * StopError(kFriction * kGravity, SubstepOf(world)); }

// m/s: how fast something may still slip that friction of `coefficient` has brought to the speed of its belt.
double Slip(const World& world, double coefficient = kFriction) {
  return 2 * SweptSpeed(coefficient * kGravity, SubstepOf(world));
}

Quaternion About(double angle) { return Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitZ())); }

/// How far friction carries what begins at rest in `seconds`, which are enough to come to the belt's speed.
double Carried(double seconds) { return kSpeed * seconds - kSpeed * kSpeed / (2 * kFriction * kGravity); }

TEST_P(Belts, CarryACrateAsFarAsTheClosedFormSays) {
  // The geometry and the entity turn the direction in which the surface runs.
  for (const auto& [run, in_entity, in_world] :
       {std::tuple{0.0, 0.0, 0.0}, {0.7, 0.0, 0.0}, {0.0, M_PI / 4, 0.0}, {0.3, 0.5, M_PI / 2}}) {
    const auto world = OnFloor(GetParam());
    EntityDesc belt = Belt(kSpeed * Vector3(std::cos(run), std::sin(run), 0));
    belt.rigid_body->geometries[0].pose_in_entity.orientation = About(in_entity);
    belt.pose.orientation = About(in_world);
    Add(*world, belt);
    const EntityId crate = Add(*world, Crate({0, 0, 1.5}));

    Steps(*world, 120);

    const double heading = run + in_entity + in_world;
    const Vector3 expected = Carried(2) * Vector3(std::cos(heading), std::sin(heading), 0) + Vector3(0, 0, 1.5);
    EXPECT_LE((PositionOf(*world, crate) - expected).norm(), WayError(*world)) << heading;
    EXPECT_NEAR(VelocityOf(*world, crate).norm(), kSpeed, Slip(*world));
  }
}

TEST_P(Belts, GiveWayToAPushAcrossThemHoweverSmall) {
  Proves({Claim::kJointSixDof});
  // Held along the belt, free across it and upwards: friction is against the slip, of which both know the direction.
  for (const double part : {0.02, 0.1, 0.5}) {
    const auto world = OnFloor(GetParam(), {.friction = kFriction});
    Add(*world, Belt({kSpeed, 0, 0}));
    const EntityId crate = Add(*world, Crate({0, 0, 1.5}));
    SixDofJoint held;
    held.along[1] = held.along[2] = JointAxis{};
    const JointId joint = Join(*world, Between({}, crate, held, {Vector3(0, 0, 1.5), Quaternion::Identity()}));
    const double friction = kFriction * kGravity;
    Do(*world, ApplyForce{.id = crate, .force = {0, part * friction, 0}, .steps = 600});

    Steps(*world, 600);

    // Of the friction that part acts across the belt.
    const double wanted = kSpeed * part / std::sqrt(1 - part * part);
    EXPECT_NEAR(VelocityOf(*world, crate).y(), wanted, 0.1 * wanted) << part;
    EXPECT_NEAR(world->layer_state().joints[joint.index()].force.x(), -friction * std::sqrt(1 - part * part),
                5e-3 * friction)
        << part;
  }
}

TEST_P(Belts, RunAlongTheirSurfaceOnly) {
  const auto world = OnFloor(GetParam());
  Add(*world, Belt({kSpeed, 0, 3}));
  const EntityId crate = Add(*world, Crate({0, 0, 1.5}));

  Steps(*world, 120);

  EXPECT_NEAR(PositionOf(*world, crate).x(), Carried(2), WayError(*world));
  EXPECT_NEAR(PositionOf(*world, crate).z(), 1.5, kTouch);
}

TEST_P(Belts, DragWithTheKineticFrictionOfTheSlipOfTheirSurface) {
  constexpr double kKinetic = 0.2;
  const auto world = OnFloor(GetParam(), {.friction = 0.8, .kinetic_friction = kKinetic});
  Add(*world, Belt({3 * kSpeed, 0, 0}));
  const EntityId crate = Add(*world, Crate({0, 0, 1.5}));

  Steps(*world, 60);

  EXPECT_NEAR(VelocityOf(*world, crate).x(), kKinetic * kGravity, 2 * kSwept * kKinetic * kGravity);
}

TEST_P(Belts, RollABallUnderneath) {
  const auto world = OnFloor(GetParam());
  Add(*world, Belt({0, kSpeed, 0}));
  const EntityId ball = Add(*world, Ball({0, 0, 1.5}));

  Steps(*world, 60);

  // The angular momentum about the surface stays nothing: m v r = 2/5 m r^2 w, and v + w r is the belt's speed.
  EXPECT_NEAR(VelocityOf(*world, ball).y(), 2 * kSpeed / 7, Slip(*world));
  EXPECT_NEAR(SpinOf(*world, ball).x(), 5 * kSpeed / 7 / 0.5, Slip(*world) / 0.5);
}

TEST_P(Belts, DriveWhoCarriesThemAndPushWhatTheyRunOver) {
  constexpr double kLight = 1, kHeavy = 3;
  // Nothing holds the slab on the floor, and the vehicle drives on the slab.
  const auto world = OnFloor(GetParam(), {.friction = 0});
  EntityDesc slab = Body(Box{{20, 2, 0.2}}, {0, 0, 0.2}, kHeavy);
  slab.rigid_body->geometries[0].material.friction = 1;
  EntityDesc vehicle = Body(Box{{0.5, 0.3, 0.1}}, {0, 0, 0.5}, kLight);
  vehicle.rigid_body->geometries[0].material.friction = 1;
  vehicle.rigid_body->geometries[0].surface_velocity = {-kSpeed, 0, 0};
  const EntityId below = Add(*world, slab), above = Add(*world, vehicle);

  Steps(*world, 60);

  const double v = VelocityOf(*world, above).x(), w = VelocityOf(*world, below).x();
  EXPECT_NEAR(v - w, kSpeed, Slip(*world, 1));
  EXPECT_NEAR(kLight * v + kHeavy * w, 0, kRounded);
}

TEST_P(Belts, KeepAwakeWhatStandsStillOnThemUntilTheyStop) {
  const auto world = OnFloor(GetParam());
  const EntityId belt = Add(*world, Belt({kSpeed, 0, 0}));
  Add(*world, Block({2, 0, 2}, {0.5, 2, 1}));
  const EntityId crate = Add(*world, Crate({0.9, 0, 1.5}));
  const auto run = [&](double speed) {
    Do(*world, UpdateEntity{belt, Belt({speed, 0, 0}), {static_cast<uint32_t>(EntityField::kGeometries)}});
  };

  Steps(*world, 180);
  EXPECT_FALSE(Asleep(*world, crate)) << "the wall holds it, and the belt drags";
  run(0);
  Steps(*world, 120);
  EXPECT_TRUE(Asleep(*world, crate));
  run(-kSpeed);
  Steps(*world, 120);
  EXPECT_NEAR(VelocityOf(*world, crate).x(), -kSpeed, Slip(*world));
}

TEST_P(Belts, GoOnAlikeOnAnotherEngine) {
  const auto world = OnFloor(GetParam());
  Add(*world, Belt({kSpeed, 0, 0}));
  const EntityId crate = Add(*world, Crate({0, 0, 1.5}));
  for (int i = 0; i < 120; ++i) {
    if (i % 10 == 0) Do(*world, SetEngine{i % 20 == 0 ? GetParam() : OtherEngine(GetParam())});
    Steps(*world, 1);
  }

  EXPECT_NEAR(PositionOf(*world, crate).x(), Carried(2), WayError(*world));
}

// By Coulomb's law for the slip of the surfaces: m mu (1 + e) v, or as much as lets a ball roll on the belt.
TEST_P(Belts, TakeAlongWhatBouncesOnThem) {
  Proves({Claim::kRestitution, Claim::kSphere});
  constexpr double kRadius = 0.1, kHeight = 0.5, kExact = 1e-4;
  for (const double restitution : {0.0, 0.8}) {
    for (const double friction : {0.05, 2.0}) {
      for (const double speed : {3.0, 60.0}) {  // m/s: the faster one is past the belt in a step
        const auto world = OnFloor(GetParam(), {.friction = friction, .restitution = restitution});
        const Vector3 along(std::cos(0.7), std::sin(0.7), 0);
        Add(*world, Belt(kSpeed * along));
        EntityDesc ball = Ball({0, 0, 1 + kRadius + kHeight}, kRadius);
        ball.rigid_body->linear_velocity = {0, 0, -speed};
        const EntityId id = Add(*world, ball);
        const double landing = std::sqrt(speed * speed + 2 * kGravity * kHeight);

        const int steps = static_cast<int>(std::ceil(kHeight / speed / kStep)) + 1;
        Steps(*world, steps);

        const double expected = std::min(friction * (1 + restitution) * landing, 2.0 / 7 * kSpeed);
        // What comes to rest on the belt is rubbed by it further on.
        const double lying = restitution > 0 ? 0 : steps * kStep - (landing - speed) / kGravity;
        const double most = std::min(expected + lying * friction * kGravity, 2.0 / 7 * kSpeed);
        const double taken = VelocityOf(*world, id).dot(along);
        EXPECT_GE(taken, (1 - kExact) * expected) << restitution << " " << friction << " " << speed;
        EXPECT_LE(taken, (1 + kExact) * most) << restitution << " " << friction << " " << speed;
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

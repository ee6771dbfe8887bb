// What hits something that joints hold feels all of it: a blow is over before anything moves, so that joints pass it on
// at once. What is known of such a blow are the laws of Newton and Coulomb and the impulses of all joints, in closed
// form.
#include <cmath>
#include <optional>
#include <string>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsBlows, Claim::kContacts, Claim::kRestitution);

constexpr double kStep = 1e-3;

Geometry& GeometryOf(EntityDesc& desc) { return desc.rigid_body->geometries[0]; }

EntityDesc Thrown(EntityDesc desc, const Vector3& velocity, double restitution, double friction = 0) {
  desc.rigid_body->linear_velocity = velocity;
  GeometryOf(desc).material.restitution = restitution;
  GeometryOf(desc).material.friction = friction;
  return desc;
}

// A rod along x from the origin, where a hinge along y holds it, and a ball that comes down on it.
struct Struck {
  explicit Struck(uint64_t seed) {
    Random random(seed);
    length = random.Uniform(0.5, 2);
    rod_mass = random.LogUniform(0.1, 10);
    ball_mass = random.LogUniform(0.1, 10);
    place = random.Uniform(0.1, 0.95) * length;
    speed = random.LogUniform(1, 20);
    restitution = seed % 3 == 0 ? 0 : random.Uniform(0.1, 1);
  }

  double impulse() const {
    const double inertia = rod_mass * (length * length / 3 + height * height / 12);
    return (1 + restitution) * speed / (1 / ball_mass + place * place / inertia);
  }

  std::unique_ptr<World> Make(const std::string& engine, std::optional<double> break_force = {}) {
    auto world = MakeSpace(engine, {.step_size = kStep}, Vector3::Zero());
    constexpr double kRadius = 0.1;
    const Box box{{length / 2, height / 2, height / 2}};
    rod = Add(*world, Thrown(Body(box, {length / 2, 0, 0}, rod_mass), Vector3::Zero(), restitution));
    const Vector3 above(place, 0, kRadius + height / 2 + 0.0103 * speed);
    ball = Add(*world, Thrown(Ball(above, kRadius, ball_mass), {0, 0, -speed}, restitution));
    JointDesc joint = ToWorld(rod, HingeJoint{}, FrameAlong(Vector3::UnitY()));
    joint.break_force = break_force;
    hinge = Join(*world, joint);
    return world;
  }

  // To the end of the step in which they met.
  void Hit(World& world) const {
    for (int step = 0; step < 20 && VelocityOf(world, ball).z() == -speed; ++step) Steps(world, 1);
  }

  double length, rod_mass, ball_mass, place, speed, restitution;
  double height = 0.04;
  EntityId rod, ball;
  JointId hinge;
};

TEST_P(JointsBlows, PassOnAllOfWhatHitsARodOnAHinge) {
  Proves({Claim::kJointHinge});
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Struck scene(seed);
    const auto world = scene.Make(GetParam());
    scene.Hit(*world);
    const double impulse = scene.impulse();
    const double inertia = scene.rod_mass * (scene.length * scene.length / 3 + scene.height * scene.height / 12);
    const double spin = impulse * scene.place / inertia;
    // The rod turns by so much in the rest of the step, and by the square of that less of its way is along z. Where the
    // two stay together, what lies between their points is beside the way as well.
    const double turn = spin * kStep;
    const double tolerance = 2 * (scene.restitution > 0 ? turn * turn : turn) + 2 * kDirect;
    EXPECT_NEAR(VelocityOf(*world, scene.ball).z(), impulse / scene.ball_mass - scene.speed, tolerance * scene.speed);
    EXPECT_NEAR(SpinOf(*world, scene.rod).y(), spin, tolerance * spin);
  }
}

TEST_P(JointsBlows, BearWhatABlowLeavesThem) {
  Proves({Claim::kJointHinge, Claim::kJointBreak});
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Struck scene(seed);
    const double impulse = scene.impulse();
    const double inertia = scene.rod_mass * (scene.length * scene.length / 3 + scene.height * scene.height / 12);
    // What keeps the middle of the rod on its circle.
    const double borne = impulse - scene.rod_mass * impulse * scene.place / inertia * scene.length / 2;
    const double force = std::abs(borne) / kStep;
    // In what is left of the step it is drawn in besides.
    const double spin = impulse * scene.place / inertia;
    const double inward = scene.rod_mass * spin * spin * scene.length / 2;
    for (const bool is_strong : {false, true}) {
      const auto world = scene.Make(GetParam(), is_strong ? 1.1 * force + inward : 0.9 * force);
      scene.Hit(*world);
      const bool is_broken = !world->CheckId(scene.hinge, "").ok();
      EXPECT_EQ(is_broken, !is_strong) << "borne " << borne << " N s";
      if (!is_broken) {
        EXPECT_NEAR(StateOf(*world, scene.hinge).force.norm(), force, 0.05 * force + inward);
      }
    }
  }
}

// Two boxes that a joint makes one, and the body that they would be.
TEST_P(JointsBlows, HitWhatIsFixedTogetherAsOneBody) {
  Proves({Claim::kJointFixed, Claim::kCompound, Claim::kStaticFriction});
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double restitution = random.Uniform(0, 1), friction = random.Uniform(0, 1), mass = random.LogUniform(0.1, 10);
    const Vector3 target(random.Uniform(-0.9, 0.9), random.Uniform(-0.3, 0.3), 0.4);
    const Vector3 velocity(random.Uniform(-3, 3), random.Uniform(-3, 3), -random.Uniform(2, 10));
    const Vector3 from = target + Vector3(0, 0, 0.1) - 0.0123 * velocity;
    const Box box{{0.5, 0.4, 0.4}};
    Vector3 after[2];
    for (const bool is_one : {false, true}) {
      const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
      EntityDesc left = Thrown(Body(box, {-0.5, 0, 0}), Vector3::Zero(), restitution, friction);
      if (is_one) {
        left.rigid_body->geometries.push_back(GeometryOf(left));
        left.rigid_body->geometries[1].pose_in_entity.position = {1, 0, 0};
        left.rigid_body->inertia.mass = 2;
        Add(*world, left);
      } else {
        const EntityId a = Add(*world, left);
        const EntityId b = Add(*world, Thrown(Body(box, {0.5, 0, 0}), Vector3::Zero(), restitution, friction));
        Join(*world, Between(a, b, FixedJoint{}));
      }
      const EntityId ball = Add(*world, Thrown(Ball(from, 0.1, mass), velocity, restitution, friction));
      Steps(*world, 14);
      after[is_one ? 1 : 0] = VelocityOf(*world, ball);
    }
    EXPECT_LT((after[0] - after[1]).norm(), 1e-4 * velocity.norm());
  }
}

// A ball that comes to lie against one of two boxes that a joint makes one, in steps of which some solve the touch:
// what one is given, another has lost, as they are shown in the end.
TEST_P(JointsBlows, KeepTheMomentumOfWhatStaysInTouch) {
  Proves({Claim::kJointFixed});
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = seed % 2 == 0 ? 1.0 / 240 : 1.0 / 60}, Vector3::Zero());
    const double friction = random.Chance(0.5) ? 0 : 0.4;
    const auto body = [&](const EntityDesc& desc) { return Add(*world, Thrown(desc, Vector3::Zero(), 0.1, friction)); };
    const EntityId a = body(Body(Box{{0.3, 0.05, 0.06}}, {-0.3, 0, 0}, random.LogUniform(0.3, 3)));
    const EntityId b = body(Body(Box{{0.3, 0.05, 0.06}}, {0.3, 0, 0}, random.LogUniform(0.3, 3)));
    Join(*world, Between(a, b, FixedJoint{}, {.position = {0.3, 0, 0}}));
    const Vector3 from(random.Uniform(-0.6, 0.6), 1, random.Uniform(-0.05, 0.05));
    const double mass = random.LogUniform(0.3, 3), speed = random.Uniform(1, 5);
    Add(*world, Thrown(Ball(from, 0.1, mass), {0, -speed, 0}, 0.1, friction));
    Steps(*world, seed % 2 == 0 ? 720 : 180);
    EXPECT_LT((MomentumOf(*world) - Vector3(0, -mass * speed, 0)).norm(), 1e-9 * mass * speed);
  }
}

// Whatever hits whatever in a row of hinged rods, and they each other: no energy comes of it.
TEST_P(JointsBlows, MakeNoEnergyInRowsThatAreHitFromAllSides) {
  Proves({Claim::kJointBall});
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = 1.0 / 240}, Vector3::Zero());
    EntityId last;
    for (int i = 0; i < 6; ++i) {
      const EntityId rod = Add(*world, Thrown(Body(Box{{0.5, 0.05, 0.05}}, {i + 0.5, 0, 0}), Vector3::Zero(), 1));
      if (i > 0) Join(*world, Between(last, rod, BallJoint{}, {.position = {0.5, 0, 0}}));
      last = rod;
    }
    for (int i = 0; i < 12; ++i) {
      const Vector3 side = random.Chance(0.5) ? Vector3::UnitZ() : Vector3(-Vector3::UnitZ());
      const Vector3 place = Vector3(random.Uniform(0, 6), 0, 0) + random.Uniform(0.3, 2) * side;
      Add(*world, Thrown(Ball(place, 0.1, random.LogUniform(0.1, 10)), -random.Uniform(0.5, 3) * side, 1));
    }
    const double start = KineticEnergyOf(*world);
    double most = 0;
    for (int step = 0; step < 480; ++step) {
      Steps(*world, 1);
      most = std::max(most, KineticEnergyOf(*world));
    }
    EXPECT_LE(most, 1.01 * start);
  }
}

// From then on it goes round by itself, whether the blow came early in a substep, late, or with its end.
TEST_P(JointsBlows, LeaveARodOnAHingeTheSpinThatTheyGaveIt) {
  Proves({Claim::kJointHinge});
  constexpr double kSpeed = 4, kRestitution = 0.5, kMass = 0.5, kPlace = 0.8, kRadius = 0.1, kHalf = 0.02;
  const double inertia = 1.0 / 3 + kHalf * kHalf / 3;
  const double impulse = (1 + kRestitution) * kSpeed / (1 / kMass + kPlace * kPlace / inertia);
  const double spin = impulse * kPlace / inertia;
  for (const double late : {-0.9, -0.5, -1e-3, 0.0, 1e-3, 0.5, 0.9}) {
    SCOPED_TRACE(late);
    const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
    const EntityId rod =
        Add(*world, Thrown(Body(Box{{0.5, kHalf, kHalf}}, {0.5, 0, 0}), Vector3::Zero(), kRestitution));
    const Vector3 above(kPlace, 0, kRadius + kHalf + kSpeed * (20 + late) * SubstepOf(*world));
    Add(*world, Thrown(Ball(above, kRadius, kMass), {0, 0, -kSpeed}, kRestitution));
    Join(*world, ToWorld(rod, HingeJoint{}, FrameAlong(Vector3::UnitY())));
    Steps(*world, 30);
    const double turn = spin * SubstepOf(*world);
    EXPECT_NEAR(SpinOf(*world, rod).y(), spin, turn * turn / 6 * spin);
  }
}

// The same where it touches something without friction meanwhile, so that an engine solves it, and is told how fast it
// goes.
TEST_P(JointsBlows, LeaveARodThatLiesOnTheFloorItsSpin) {
  Proves({Claim::kJointHinge});
  constexpr double kSpin = 5, kHalf = 0.02;
  WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero()};
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  EntityDesc rod = Body(Box{{0.5, kHalf, kHalf}}, {0.5, 0, kHalf});
  GeometryOf(rod).material.friction = 0;
  const EntityId id = Add(*world, rod);
  Join(*world, ToWorld(id, HingeJoint{}, FrameAlong(Vector3::UnitZ(), {0, 0, kHalf})));
  Steps(*world, 20);
  Do(*world, SetVelocity{id, Vector3(0, kSpin / 2, 0), Vector3(0, 0, kSpin)});
  Steps(*world, 30);
  const double turn = kSpin * SubstepOf(*world);
  EXPECT_NEAR(SpinOf(*world, id).z(), kSpin, turn * turn / 6 * kSpin);
}

}  // namespace
}  // namespace genphys::testing

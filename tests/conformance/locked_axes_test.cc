// Axes along and about which an entity cannot move: not by a bit, whatever pushes it, on every engine.
#include <cmath>

#include "engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Locks, Claim::kLockedAxes);

constexpr double kGravity = 9.81;
// Orientations are normalised once a substep.
constexpr double kNoTilt = kRounded;

constexpr LockedAxes kFlat{{false, true, false}, {true, false, true}};  // moves in the plane of x and z
constexpr LockedAxes kFixed{{true, true, true}, {true, true, true}};

EntityDesc Locked(EntityDesc desc, const LockedAxes& locks) {
  desc.rigid_body->locked_axes = locks;
  return desc;
}

Quaternion OrientationOf(const World& world, EntityId id) {
  return FromColumn(world.state().orientations.col(id.index()));
}

TEST_P(Locks, KeepAPileInItsPlane) {
  const auto world = MakeWorld();
  std::vector<EntityId> ids;
  for (int i = 0; i < 8; ++i) {
    // Stacked out of line, so that each would fall out of the plane to its own side.
    const double y = 0.3 * (i % 3 - 1);
    EntityDesc desc =
        i % 2 == 0 ? Crate({0.2 * i, y, 0.6 + 1.1 * i}) : Body(Capsule{0.3, 0.4}, {0.1, y, 0.6 + 1.1 * i});
    desc.rigid_body->angular_velocity = {1, 2, 3};
    desc.rigid_body->linear_velocity = {0, 1, 0};
    // Or who lands on its side may roll on for ever.
    desc.rigid_body->geometries[0].material.rolling_friction = 0.05;
    ids.push_back(Add(*world, Locked(desc, kFlat)));
  }
  const StateArrays before = world->state();

  Steps(*world, 420);

  for (const EntityId id : ids) {
    EXPECT_EQ(PositionOf(*world, id).y(), before.positions(1, id.index())) << "not a bit";
    EXPECT_LE((OrientationOf(*world, id) * Vector3::UnitY() - Vector3::UnitY()).norm(), kNoTilt);
    EXPECT_GT(PositionOf(*world, id).z(), 0.2) << "it lies on something";
    EXPECT_TRUE(Asleep(*world, id)) << "and lies still";
  }
}

TEST_P(Locks, LeaveOutWhatAVelocityOrAnImpulseSaysAlongThem) {
  const auto world = MakeSpace(GetParam(), {}, {0, 0, -kGravity});
  EntityDesc desc = Crate({1, 2, 3});
  desc.rigid_body->linear_velocity = {4, 5, 6};
  const EntityId id = Add(*world, Locked(desc, {{false, false, true}, {true, true, false}}));
  EXPECT_EQ(VelocityOf(*world, id), Vector3(4, 5, 0));

  Do(*world, SetVelocity{id, Vector3(1, 1, 1), Vector3(1, 1, 1)});
  EXPECT_EQ(VelocityOf(*world, id), Vector3(1, 1, 0));
  EXPECT_EQ(SpinOf(*world, id), Vector3(0, 0, 1));
  Do(*world, ApplyImpulse{.id = id, .linear = {1, 0, 9}, .angular = {7, 0, 0}});
  EXPECT_LE((VelocityOf(*world, id) - Vector3(2, 1, 0)).norm(), kNoTilt);
  Steps(*world, 60);

  EXPECT_EQ(PositionOf(*world, id).z(), 3) << "it does not fall";
  EXPECT_NEAR(PositionOf(*world, id).x(), 1 + 2, kNoTilt * 60);
  Do(*world, SetPose{.id = id, .position = Vector3(0, 0, 7)});
  Steps(*world, 60);
  EXPECT_EQ(PositionOf(*world, id).z(), 7) << "it is held where it was put";
}

TEST_P(Locks, AreAsHardAsAWallToWhatHitsThem) {
  constexpr double kSpeed = 3, kMass = 0.1;
  // A contact gives way by a part of what both sides would without locks.
  constexpr double kTolerance = kDirect * (1 + 1 / kMass) * kSpeed;
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  Require(*world, Feature::kContacts);
  const EntityId post = Add(*world, Locked(Crate({0, 0, 0}, 0.5, kMass), kFixed));
  EntityDesc ball = Ball({-1.5, 0, 0});
  ball.rigid_body->linear_velocity = {kSpeed, 0, 0};
  const EntityId id = Add(*world, ball);

  Steps(*world, 60);

  EXPECT_NEAR(VelocityOf(*world, id).norm(), 0, kTolerance) << "a tenth of its mass stops it";
  EXPECT_EQ(PositionOf(*world, post), Vector3(0, 0, 0));
  EXPECT_EQ(OrientationOf(*world, post).coeffs(), Quaternion::Identity().coeffs());
}

TEST_P(Locks, LeaveWhatBouncesInAPlaneItsEnergy) {
  Proves({Claim::kRestitution});
  WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}, .ground_plane = true};
  desc.default_material = {.friction = 0, .restitution = 1};
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  EntityDesc box = Body(Box{{0.3, 0.2, 0.1}}, {0, 0, 3});
  box.pose.orientation = Quaternion(Eigen::AngleAxisd(0.6, Vector3::UnitY()));
  box.rigid_body->angular_velocity = {0, 2, 0};
  const EntityId id = Add(*world, Locked(box, kFlat));
  const double inertia = world->scene().entities[id.index()]->mass.tensor(1, 1);
  const auto energy = [&] {
    const double spin = SpinOf(*world, id).y();
    return VelocityOf(*world, id).squaredNorm() / 2 + inertia * spin * spin / 2 + kGravity * PositionOf(*world, id).z();
  };
  const double before = energy();
  for (int i = 0; i < 1200; ++i) {
    Steps(*world, 1);
    ASSERT_NEAR(energy(), before, 1e-6 * before) << "step " << i;
  }
}

TEST_P(Locks, KeepAPushedCrateFromTipping) {
  constexpr double kForce = 8, kFriction = 0.5;
  const auto world = MakeWorld();
  const EntityId upright = Add(*world, Locked(Body(Box{{0.1, 0.1, 1}}, {0, 0, 1}), {{}, {true, true, true}}));
  const EntityId free = Add(*world, Body(Box{{0.1, 0.1, 1}}, {0, 5, 1}));
  for (const EntityId id : {upright, free}) {
    Do(*world,
       ApplyForce{.id = id, .force = {kForce, 0, 0}, .point = PositionOf(*world, id) + Vector3(0, 0, 1), .steps = 60});
  }

  Steps(*world, 60);

  EXPECT_EQ(OrientationOf(*world, upright).coeffs(), Quaternion::Identity().coeffs());
  const double acceleration = kForce - kFriction * kGravity;
  EXPECT_NEAR(VelocityOf(*world, upright).x(), acceleration, 2 * kSwept * kFriction * kGravity);
  EXPECT_GT(OrientationOf(*world, free).angularDistance(Quaternion::Identity()), 0.5) << "the other one fell";
}

TEST_P(Locks, KeepTheAngularMomentumAboutTheFreeAxis) {
  constexpr double kSpin = 5;
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  // Its principal axes are not those of the world, so that without locks it would tumble.
  EntityDesc desc = Body(Box{{0.1, 0.5, 1}}, {0, 0, 0});
  desc.pose.orientation = Quaternion(Eigen::AngleAxisd(0.7, Vector3(1, 2, 0.5).normalized()));
  desc.rigid_body->angular_velocity = {0, 0, kSpin};
  const EntityId id = Add(*world, Locked(desc, {{}, {true, true, false}}));
  const Vector3 up = OrientationOf(*world, id).conjugate() * Vector3::UnitZ();

  Steps(*world, 600);

  // The moment about the axis about which it turns does not change, and neither does the rate.
  EXPECT_LE((SpinOf(*world, id) - Vector3(0, 0, kSpin)).norm(), kNoTilt * 600);
  EXPECT_LE((OrientationOf(*world, id) * up - Vector3::UnitZ()).norm(), kNoTilt * 600);
}

TEST_P(Locks, HoldAgainstAKinematicPusherAndAJoint) {
  const auto world = MakeSpace(GetParam(), {}, {0, 0, -kGravity});
  const EntityId held = Add(*world, Locked(Crate({0, 0, 0}), kFixed));
  const EntityId ball = Add(*world, Ball({0, 0, -2}));
  const JointId rope = Join(*world, Between(held, ball, BallJoint{}));
  EntityDesc pusher = Block({-2, 0, 0}, {0.5, 0.5, 0.5});
  pusher.rigid_body->motion_type = MotionType::kKinematic;
  pusher.rigid_body->linear_velocity = {1, 0, 0};
  Add(*world, pusher);

  Steps(*world, 30);
  EXPECT_NEAR(StateOf(*world, rope).force.norm(), kGravity, kDirect * kGravity);
  Steps(*world, 150);

  EXPECT_EQ(PositionOf(*world, held), Vector3(0, 0, 0));
  EXPECT_TRUE(PositionOf(*world, ball).allFinite());
}

TEST_P(Locks, ComeAndGoWhileTheWorldRunsAndOnAnotherEngine) {
  const auto world = MakeWorld();
  const EntityId id = Add(*world, Ball({0, 0, 5}));
  const EntityFields fields{static_cast<uint32_t>(EntityField::kLockedAxes)};
  Steps(*world, 10);
  const double height = PositionOf(*world, id).z();
  Do(*world, UpdateEntity{id, Locked(Ball({0, 0, 0}), {{false, false, true}, {}}), fields});
  EXPECT_EQ(VelocityOf(*world, id).z(), 0);
  for (const std::string& engine : {GetParam(), OtherEngine(GetParam()), GetParam()}) {
    Do(*world, SetEngine{engine});
    Steps(*world, 30);
    EXPECT_EQ(PositionOf(*world, id).z(), height);
  }
  const uint64_t locked = world->StateHash();
  Do(*world, UpdateEntity{id, Locked(Ball({0, 0, 0}), {}), fields});
  EXPECT_NE(world->StateHash(), locked);
  Steps(*world, 120);

  EXPECT_NEAR(PositionOf(*world, id).z(), 0.5, kTouch) << "it fell to the floor";
}

TEST_P(Locks, MeanNothingToAKinematicEntity) {
  const auto world = MakeWorld();
  EntityDesc desc = Block({0, 0, 5}, {1, 1, 1});
  desc.rigid_body->motion_type = MotionType::kKinematic;
  desc.rigid_body->linear_velocity = {0, 0, 1};
  const EntityId id = Add(*world, Locked(desc, kFixed));

  Steps(*world, 60);

  EXPECT_NEAR(PositionOf(*world, id).z(), 6, kRounded * 60);
}

}  // namespace
}  // namespace genphys::testing

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <thread>

#include "bullet_test_bench.h"

namespace genphys {
namespace {

using namespace bullet_test;

constexpr double kPi = std::numbers::pi;
// Products and sums of a few dozen steps in double precision, on values around one.
constexpr double kRounding = 1e-12;
// m and m/s: where ten iterations a step, each going on from the last, have come to within a second or two.
constexpr double kSettled = 1e-6;

TEST(BulletBackend, PassesItsSelfTest) { EXPECT_EQ(MakeBulletBackend()->SelfTest(), absl::OkStatus()); }

TEST(BulletBackend, ListsOnlyWhatItCan) {
  const auto backend = MakeBulletBackend();
  const Capabilities& capabilities = backend->capabilities();

  EXPECT_EQ(capabilities.engine(), "bullet");
  EXPECT_EQ(capabilities.version(), "3.24");
  EXPECT_TRUE(capabilities.Has(Feature::kShapeCylinder));
  EXPECT_TRUE(capabilities.Has(Feature::kSolverIterative));
  EXPECT_TRUE(capabilities.Has(Feature::kSolverDirect));
  EXPECT_TRUE(capabilities.Has(Feature::kShapeConvexHull));
  EXPECT_FALSE(capabilities.Has(Feature::kDynamicTriangleMesh));
  EXPECT_TRUE(capabilities.Has(Feature::kJointGear));
}

TEST(BulletBackend, TakesWhatIsSetBeforeWhatThePresetMeans) {
  const auto backend = MakeBulletBackend();
  const auto substeps = [&](Quality quality) {
    StepperDesc stepper;
    stepper.quality = quality;
    return backend->Resolve(stepper).substeps;
  };

  EXPECT_EQ(substeps(Quality::kFast), 1u);
  EXPECT_EQ(substeps(Quality::kBalanced), 2u);
  EXPECT_EQ(substeps(Quality::kAccurate), 8u);
  EXPECT_EQ(backend->Resolve({}), (StepperSettings{Solver::kAutomatic, 2, 10, true}));
  StepperDesc own;
  own.substeps = 3;
  own.iterations = 7;
  EXPECT_EQ(backend->Resolve(own), (StepperSettings{Solver::kAutomatic, 3, 7}));
}

TEST(BulletMotion, FollowsTheVelocityExactly) {
  Bench bench;
  bench.gravity.setZero();
  RigidBody body = Bench::Describe(kUnitBox);
  body.linear_velocity = {1, -2, 3};
  // Two radians in one step, where Bullet's own integrator turns by no more than an eighth of a circle.
  body.angular_velocity = {0, 0, 20};
  const EntityRow row = bench.Add(body);

  bench.Run(1, 0.1);

  EXPECT_LT((bench.position(row) - Vector3(0.1, -0.2, 0.3)).norm(), kRounding);
  EXPECT_LT(bench.state.pose(row).orientation.angularDistance(TurnedBy(2, Vector3::UnitZ())), kRounding);
  EXPECT_EQ(bench.velocity(row), Vector3(1, -2, 3));
  EXPECT_EQ(bench.spin(row), Vector3(0, 0, 20));
}

TEST(BulletMotion, LeavesWhatDoesNotMoveBitForBitWhereItIs) {
  Bench bench;
  bench.gravity.setZero();
  const Pose pose{{0.1, 0.2, 0.3}, Quaternion(0.1, 0.2, 0.3, 0.4).normalized()};
  RigidBody body = Bench::Describe(kUnitBox);
  body.inertia.mass = 1;
  body.inertia.center_of_mass = Vector3(0.1, 0.2, 0.3);
  const EntityRow row = bench.Add(body, pose);

  bench.Run(3);

  EXPECT_EQ(bench.state.pose(row), pose);
}

TEST(BulletMotion, TurnsAboutTheCentreOfMass) {
  Bench bench;
  bench.gravity.setZero();
  RigidBody body = Bench::Describe(kUnitBall);
  body.inertia.mass = 1;
  body.inertia.center_of_mass = Vector3(1, 0, 0);
  body.angular_velocity = {0, 0, kPi};
  const EntityRow row = bench.Add(body);

  bench.Run(10, 0.1);

  // Half a turn about the point one metre away.
  EXPECT_LT((bench.position(row) - Vector3(2, 0, 0)).norm(), kRounding);
}

TEST(BulletMotion, AnswersAnImpulseByTheWholeTensor) {
  Bench bench;
  bench.gravity.setZero();
  bench.friction = 0;
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  RigidBody body = Bench::Describe(kUnitBall);
  Matrix3 tensor;
  tensor << 0.3, 0.1, -0.05, 0.1, 0.4, 0.08, -0.05, 0.08, 0.5;
  body.inertia.mass = 1;
  body.inertia.center_of_mass = Vector3(0.2, 0.1, 0);
  body.inertia.tensor = tensor;
  body.linear_velocity = {0, 0, -1};
  const Quaternion orientation = TurnedBy(0.7, {1, 2, 3});
  const EntityRow row = bench.Add(body, {{0, 0, 0.5}, orientation});

  bench.Run(1);

  // The point below the middle of the ball is stopped by one impulse along z.
  const Matrix3 rotation = orientation.toRotationMatrix();
  const Matrix3 inverse = rotation * tensor.inverse() * rotation.transpose();
  const Vector3 arm = Vector3(0, 0, -0.5) - rotation * *body.inertia.center_of_mass;
  const Vector3 lever = arm.cross(Vector3::UnitZ());
  const double impulse = 1 / (1 + lever.dot(inverse * lever));
  EXPECT_NEAR(bench.velocity(row).z(), impulse - 1, kRounding);
  EXPECT_LT((bench.spin(row) - impulse * inverse * lever).norm(), kRounding);
}

class BulletResting : public testing::TestWithParam<std::pair<const char*, Shape>> {};

TEST_P(BulletResting, StaysWhereItIsOnAPlaneAndOnABox) {
  const Shape& shape = GetParam().second;
  for (const bool on_plane : {true, false}) {
    Bench bench;
    bench.Add(on_plane ? Shape(kGround) : Shape(Box{{5, 5, 1}}), {0, 0, on_plane ? 0.0 : -1.0}, MotionType::kStatic);
    const EntityRow body = bench.Add(shape, {0, 0, 0.5});

    bench.Run(360);

    // The eight corners that stand for the rim of a cylinder take turns in carrying it.
    const double drift = std::holds_alternative<Cylinder>(shape) ? 1e-3 : kSettled;
    EXPECT_LT((bench.position(body) - Vector3(0, 0, 0.5)).norm(), drift) << on_plane;
    EXPECT_NEAR(bench.NormalImpulse() / (bench.Mass(shape) * kGravity * kStep), 1, 1e-3) << on_plane;
  }
}

INSTANTIATE_TEST_SUITE_P(Bullet, BulletResting,
                         testing::Values(std::pair{"Box", Shape{Box{{0.4, 0.3, 0.5}}}},
                                         std::pair{"Sphere", Shape{Sphere{0.5}}},
                                         std::pair{"Cylinder", Shape{Cylinder{0.3, 0.5}}},
                                         std::pair{"Capsule", Shape{Capsule{0.2, 0.3}}}),
                         [](const auto& param) { return param.param.first; });

TEST(BulletResting, KeepsALyingCapsuleAndALyingCylinderFromRolling) {
  for (const Shape& shape : {Shape{Capsule{0.25, 0.5}}, Shape{Cylinder{0.25, 0.5}}}) {
    Bench bench;
    bench.Add(Box{{5, 5, 1}}, {0, 0, -1}, MotionType::kStatic);
    const EntityRow body = bench.Add(Bench::Describe(shape), {{0, 0, 0.25}, TurnedBy(kPi / 2, Vector3::UnitY())});

    bench.Run(240);

    EXPECT_EQ(bench.contacts.points.size(), 2u);
    EXPECT_LT((bench.position(body) - Vector3(0, 0, 0.25)).norm(), kSettled);
  }
}

TEST(BulletResting, HoldsAStackOfTenBoxes) {
  Bench bench;
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  std::vector<EntityRow> boxes;
  for (int i = 0; i < 10; ++i) boxes.push_back(bench.Add(kUnitBox, {0, 0, 0.5 + i}));

  bench.Run(1200);

  constexpr double kLean = 0.02;  // m: ten iterations cannot carry the load of ten boxes down at once
  for (int i = 0; i < 10; ++i) EXPECT_LT((bench.position(boxes[i]) - Vector3(0, 0, 0.5 + i)).norm(), kLean) << i;
}

TEST(BulletResting, GoesOnWhereItWasWhenAStackIsWoken) {
  Bench bench;
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  std::vector<EntityRow> boxes;
  for (int i = 0; i < 5; ++i) boxes.push_back(bench.Add(kUnitBox, {0, 0, 0.5 + i}));
  bench.Run(600);

  for (const EntityRow box : boxes) bench.SetActive(box, false);
  bench.Collide();
  ASSERT_TRUE(bench.contacts.pairs.empty());
  for (const EntityRow box : boxes) bench.SetActive(box, true);

  for (int i = 0; i < 10; ++i) {
    bench.Run(1);
    for (const EntityRow box : boxes) EXPECT_LT(bench.velocity(box).norm(), kSettled);
  }
}

TEST(BulletResting, GoesOnWhereItWasFromImpulsesThatAreRecalled) {
  const auto build = [](Bench& bench) {
    bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
    for (int i = 0; i < 5; ++i) bench.Add(kUnitBox, {0, 0, 0.5 + i});
  };
  StepperDesc few;
  few.iterations = 1;
  Bench before(few), recalling(few), starting(few);
  for (Bench* bench : {&before, &recalling, &starting}) build(*bench);
  before.Run(2400);
  for (Bench* bench : {&recalling, &starting}) {
    bench->state = before.state;
    for (const EntityRow row : bench->moving) bench->Put(row, bench->state.pose(row));
  }

  recalling.world->Recall(before.contacts);
  recalling.Run(1);
  starting.Run(1);

  // One iteration cannot find what holds five boxes, but it can keep it.
  const EntityRow lowest = before.moving.front();
  EXPECT_LT(recalling.velocity(lowest).norm(), 1e-3);
  EXPECT_GT(starting.velocity(lowest).norm(), 1e-2);
}

TEST(BulletResting, HasNoSpeedAfterADeepOverlap) {
  Bench bench;
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  const EntityRow box = bench.Add(kUnitBox, {0, 0, 0.4});

  // m/s: ten centimetres are taken away in a few steps, and moving the box disturbs the balance of its corners.
  constexpr double kDisturbed = 1e-5;
  for (int i = 0; i < 60; ++i) {
    bench.Run(1);
    EXPECT_LT(std::abs(bench.velocity(box).z()), kDisturbed);
  }

  EXPECT_NEAR(bench.position(box).z(), 0.5, kSettled);
}

TEST(BulletFriction, BrakesAlikeInEveryDirection) {
  constexpr double kSpeed = 3;
  for (const double heading : {0.0, 0.3, kPi / 4, 2.0}) {
    Bench bench;
    bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
    RigidBody body = Bench::Describe(Box{{0.5, 0.5, 0.1}});
    const Vector3 direction(std::cos(heading), std::sin(heading), 0);
    body.linear_velocity = kSpeed * direction;
    const EntityRow box = bench.Add(body, {{0, 0, 0.1}, Quaternion::Identity()});

    bench.Run(240);

    // The steps take the speed at their end: n of them fall short of the closed form by half a step's worth.
    const double deceleration = bench.friction * kGravity;
    const double expected = kSpeed * kSpeed / (2 * deceleration) - kSpeed * kStep / 2;
    // m: the last step stops the box before its end.
    const double kLastStep = deceleration * kStep * kStep;
    EXPECT_NEAR((bench.position(box) - Vector3(0, 0, 0.1)).dot(direction), expected, kLastStep) << heading;
    EXPECT_NEAR((bench.position(box) - Vector3(0, 0, 0.1)).cross(direction).norm(), 0, kSettled) << heading;
  }
}

TEST(BulletFriction, PushesAgainstTheSlide) {
  for (const bool box_is_first : {true, false}) {
    Bench bench;
    if (!box_is_first) bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
    RigidBody body = Bench::Describe(Box{{0.5, 0.5, 0.1}});
    body.linear_velocity = {3, 0, 0};
    bench.Add(body, {{0, 0, 0.1}, Quaternion::Identity()});
    if (box_is_first) bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);

    bench.Run(1);

    Vector3 on_box = Vector3::Zero();
    for (const ContactPoint& point : bench.contacts.points) {
      on_box += (box_is_first ? -1 : 1) * (point.normal_impulse * point.normal + point.friction_impulse);
    }
    const double load = bench.Mass(Box{{0.5, 0.5, 0.1}}) * kGravity * kStep;
    EXPECT_LT((on_box / load - Vector3(-bench.friction, 0, 1)).norm(), kSettled) << box_is_first;
  }
}

TEST(BulletFriction, HoldsBelowItsCoefficientAndSlidesAboveIt) {
  for (const double share : {0.99, 1.01}) {
    Bench bench;
    const double angle = std::atan(share * bench.friction);
    bench.gravity = kGravity * Vector3(std::sin(angle), 0, -std::cos(angle));
    bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
    const EntityRow box = bench.Add(Box{{0.2, 0.2, 0.05}}, {0, 0, 0.05});

    bench.Run(120);

    const double acceleration = kGravity * (std::sin(angle) - bench.friction * std::cos(angle));
    EXPECT_NEAR(bench.velocity(box).x(), std::max(0.0, acceleration), kSettled) << share;
  }
}

TEST(BulletFriction, TurnsASlideIntoRolling) {
  Bench bench;
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  RigidBody body = Bench::Describe(kUnitBall);
  body.linear_velocity = {3, 4, 0};
  const EntityRow ball = bench.Add(body, {{0, 0, 0.5}, Quaternion::Identity()});

  bench.Run(240);

  EXPECT_LT((bench.velocity(ball) - 5.0 / 7 * Vector3(3, 4, 0)).norm(), kSettled);
  EXPECT_LT((bench.velocity(ball) - bench.spin(ball).cross(Vector3(0, 0, 0.5))).norm(), kSettled);
}

TEST(BulletBodies, LetABallFallOffTheEdgeOfABox) {
  Bench bench;
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  bench.Add(kUnitBox, {0, 0, 0.5}, MotionType::kStatic);
  const EntityRow ball = bench.Add(kUnitBall, {0.7, 0, 5});

  bench.Run(600);

  EXPECT_GT(bench.position(ball).x(), 1);
  EXPECT_EQ(bench.position(ball).y(), 0);
  EXPECT_NEAR(bench.position(ball).z(), 0.5, kSettled);
}

TEST(BulletBodies, KeepTheMomentumOfAnOffCentreHit) {
  Bench bench;
  bench.gravity.setZero();
  RigidBody moving = Bench::Describe(Box{{0.5, 0.2, 0.3}});
  moving.linear_velocity = {2, 0.3, 0};
  moving.angular_velocity = {0, 1, 2};
  const EntityRow a = bench.Add(moving, {{-1, 0.1, 0.2}, TurnedBy(0.4, {1, 1, 0})});
  const EntityRow b = bench.Add(kUnitBox, {0.05, 0, 0});
  // At the poses of the hit: afterwards the two are moved apart.
  const StateArrays at_hit = bench.state;
  const auto momentum = [&](bool angular) {
    Vector3 sum = Vector3::Zero();
    for (const auto& [row, shape] : {std::pair{a, Box{{0.5, 0.2, 0.3}}}, {b, kUnitBox}}) {
      const MassProperties mass = ComputeMassProperties(Bench::Describe(shape)).value();
      const Matrix3 rotation = at_hit.pose(row).orientation.toRotationMatrix();
      const Vector3 position = at_hit.pose(row).position;
      sum += angular ? Vector3(mass.mass * position.cross(bench.velocity(row)) +
                               rotation * mass.tensor * rotation.transpose() * bench.spin(row))
                     : Vector3(mass.mass * bench.velocity(row));
    }
    return sum;
  };
  const Vector3 linear_before = momentum(false), angular_before = momentum(true);

  bench.Collide();
  ASSERT_FALSE(bench.contacts.points.empty());
  bench.Solve();

  EXPECT_GT(bench.NormalImpulse(), 1);
  EXPECT_LT((momentum(false) - linear_before).norm() / linear_before.norm(), kRounding);
  EXPECT_LT((momentum(true) - angular_before).norm() / angular_before.norm(), kRounding);
}

TEST(BulletBodies, RideOnAKinematicOne) {
  for (const bool belt_is_first : {true, false}) {
    Bench bench;
    RigidBody belt = Bench::Describe(Box{{5, 5, 0.5}}, MotionType::kKinematic);
    belt.linear_velocity = {1, 0.5, 0.25};
    if (belt_is_first) bench.Add(belt);
    const EntityRow box = bench.Add(Box{{0.5, 0.5, 0.1}}, {0, 0, 0.6});
    if (!belt_is_first) bench.Add(belt);
    const EntityRow belt_row{belt_is_first ? 0u : 1u};

    for (int i = 0; i < 120; ++i) {
      bench.Run(1);
      const Vector3 moved = bench.position(belt_row) + kStep * bench.velocity(belt_row);
      bench.Put(belt_row, {moved, Quaternion::Identity()});
    }

    EXPECT_LT((bench.velocity(box) - Vector3(1, 0.5, 0.25)).norm(), kSettled) << belt_is_first;
    EXPECT_EQ(bench.velocity(belt_row), belt.linear_velocity);
  }
}

TEST(BulletBodies, AreNotPushedBySensors) {
  Bench bench;
  RigidBody zone = Bench::Describe(kUnitBox, MotionType::kStatic);
  zone.geometries[0].is_sensor = true;
  bench.Add(zone);
  const EntityRow ball = bench.Add(kUnitBall, {0, 0, 0.2});

  bench.Run(1);

  ASSERT_EQ(bench.contacts.pairs.size(), 1u);
  EXPECT_TRUE(bench.contacts.pairs[0].is_sensor);
  EXPECT_EQ(bench.NormalImpulse(), 0);
  EXPECT_EQ(bench.velocity(ball), Vector3(0, 0, -kGravity * kStep));
}

TEST(BulletBodies, AreCarriedByInactiveOnesThatStayWhereTheyAre) {
  Bench bench;
  const EntityRow sleeper = bench.Add(kUnitBox, {0, 0, 0.5});
  const EntityRow box = bench.Add(kUnitBox, {0, 0, 1.5});
  bench.SetActive(sleeper, false);

  bench.Run(120);

  EXPECT_EQ(bench.position(sleeper), Vector3(0, 0, 0.5));
  EXPECT_NEAR(bench.position(box).z(), 1.5, kSettled);

  bench.SetActive(sleeper, true);
  bench.Run(120);

  EXPECT_NEAR(bench.position(sleeper).z(), 0.5 - kGravity / 2, 0.1) << "it should fall when woken";
}

TEST(BulletBodies, AreFoundWhereTheyWerePut) {
  Bench bench;
  bench.gravity.setZero();
  bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  const EntityRow box = bench.Add(kUnitBox, {0, 0, 0.5});
  bench.Run(2);
  ASSERT_EQ(bench.contacts.pairs.size(), 1u);

  for (const bool active : {true, false}) {
    bench.SetActive(box, active);
    const double x = active ? 100 : -100;
    bench.Put(box, {{x, 0, 7}, Quaternion::Identity()});
    bench.Collide();

    EXPECT_TRUE(bench.contacts.pairs.empty()) << "points of the old place are still there";
    EXPECT_EQ(bench.position(box), Vector3(x, 0, 7));
  }
}

}  // namespace
}  // namespace genphys

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <thread>

#include "ode_test_bench.h"
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace genphys {
namespace {

using namespace ode_test;

StepperDesc Preset(Quality quality) {
  StepperDesc stepper;
  stepper.quality = quality;
  return stepper;
}

StepperDesc With(Solver solver) {
  StepperDesc stepper;
  stepper.solver = solver;
  return stepper;
}

double TotalImpulse(const ContactBuffer& contacts) {
  double sum = 0;
  for (const ContactPoint& point : contacts.points) sum += point.normal_impulse;
  return sum;
}

TEST(OdeBackend, PassesItsSelfTest) { EXPECT_TRUE(MakeOdeBackend()->SelfTest().ok()); }

TEST(OdeBackend, ListsOnlyWhatItCan) {
  const auto backend = MakeOdeBackend();
  EXPECT_EQ(backend->capabilities().engine(), "ode");
  EXPECT_EQ(backend->capabilities().version(), "0.16.2");
  EXPECT_TRUE(backend->capabilities().Has(Feature::kSolverDirect));
  EXPECT_TRUE(backend->capabilities().Has(Feature::kShapeConvexHull));
  EXPECT_FALSE(backend->capabilities().Has(Feature::kDynamicTriangleMesh));
  EXPECT_TRUE(backend->capabilities().Has(Feature::kJointGear));
}

TEST(OdeBackend, TakesWhatIsSetBeforeWhatThePresetMeans) {
  const auto backend = MakeOdeBackend();
  const auto fast = backend->Resolve(Preset(Quality::kFast));
  EXPECT_EQ(
      fast,
      (StepperSettings{
          .solver = Solver::kAutomatic, .substeps = 1, .iterations = 10, .may_go_on = true, .jointed_rows_max = 60}));
  EXPECT_EQ(backend->Resolve(Preset(Quality::kAccurate)).substeps, 4u);
  EXPECT_EQ(backend->Resolve(Preset(Quality::kAccurate)).jointed_rows_max, 160u);
  EXPECT_FALSE(backend->Resolve({.iterations = 10}).may_go_on) << "so many were asked for";
  const auto own = backend->Resolve({.solver = Solver::kDirect, .substeps = 3, .iterations = 7});
  EXPECT_EQ(own, (StepperSettings{.solver = Solver::kDirect, .substeps = 3, .iterations = 7}));
}

TEST(OdeBackend, MovesAFreeBodyByItsVelocity) {
  Bench bench;
  bench.gravity = 0;
  RigidBody body = Bench::BodyOf(kUnitBox);
  body.linear_velocity = {1, -2, 3};
  body.angular_velocity = {0, 0, 5};
  const EntityRow row = bench.Add(body, {});

  bench.Step(0.1);

  EXPECT_LT((bench.position(row) - Vector3(0.1, -0.2, 0.3)).norm(), kRounding);
  const Quaternion turned(Eigen::AngleAxisd(0.5, Vector3::UnitZ()));
  EXPECT_LT(bench.state.pose(row).orientation.angularDistance(turned), kRounding);
  EXPECT_EQ(bench.velocity(row), Vector3(1, -2, 3));
}

TEST(OdeBackend, LeavesAMotionlessBodyBitForBitWhereItIs) {
  Bench bench;
  bench.gravity = 0;
  const Pose pose{{0.1, 0.2, 0.3}, Quaternion(0.1, 0.2, 0.3, 0.4).normalized()};
  const EntityRow row = bench.Add(Bench::BodyOf(kUnitBox), pose);

  bench.Step();

  EXPECT_EQ(bench.position(row), pose.position);
  EXPECT_LT((bench.state.orientations.col(Index(row)) - ToColumn(pose.orientation)).norm(), 1e-15);
}

TEST(OdeBackend, TurnsABodyAboutItsCentreOfMass) {
  Bench bench;
  bench.gravity = 0;
  RigidBody body = Bench::BodyOf(kUnitBall);
  body.inertia.mass = 1;
  body.inertia.center_of_mass = Vector3(1, 0, 0);
  body.inertia.tensor = Matrix3::Identity();
  body.angular_velocity = {0, 0, M_PI};
  const EntityRow row = bench.Add(body, {});

  for (int i = 0; i < 10; ++i) bench.Step(0.1);

  // Half a turn about the point one metre away.
  EXPECT_LT((bench.position(row) - Vector3(2, 0, 0)).norm(), kRounding);
}

TEST(OdeBackend, TellsThatABallLandsAndRests) {
  Bench bench;
  bench.AddGround();
  const EntityRow ball = bench.Add(kUnitBall, {0, 0, 1});

  bench.Run(3);

  EXPECT_NEAR(bench.position(ball).z(), 0.5, kRestError);
  ASSERT_EQ(bench.contacts.pairs.size(), 1u);
  const double weight = ComputeMassProperties(Bench::BodyOf(kUnitBall)).value().mass * kGravity;
  constexpr double kForceError = 1e-6;  // of a body at rest, relative
  EXPECT_NEAR(TotalImpulse(bench.contacts) / (weight * kStep), 1, kForceError);
}

class RestingShape : public testing::TestWithParam<std::pair<const char*, Shape>> {};

TEST_P(RestingShape, StaysWhereItIsOnThePlaneAndOnABox) {
  for (const bool on_plane : {true, false}) {
    Bench bench;
    on_plane ? bench.AddGround() : (void)bench.Add(Box{{5, 5, 1}}, {0, 0, -1}, MotionType::kStatic);
    const EntityRow body = bench.Add(GetParam().second, {0, 0, 0.5});

    bench.Run(2);

    EXPECT_LT((bench.position(body) - Vector3(0, 0, 0.5)).norm(), kRestError) << on_plane;
  }
}

INSTANTIATE_TEST_SUITE_P(OdeBackend, RestingShape,
                         testing::Values(std::pair{"Box", Shape{Box{{0.4, 0.3, 0.5}}}},
                                         std::pair{"Sphere", Shape{Sphere{0.5}}},
                                         std::pair{"Cylinder", Shape{Cylinder{0.3, 0.5}}},
                                         std::pair{"Capsule", Shape{Capsule{0.2, 0.3}}}),
                         [](const auto& param) { return param.param.first; });

TEST(OdeBackend, HoldsAStackOfFiveBoxes) {
  Bench bench;
  bench.AddGround();
  std::vector<EntityRow> boxes;
  for (int i = 0; i < 5; ++i) boxes.push_back(bench.Add(kUnitBox, {0, 0, 0.5 + i}));

  bench.Run(5);

  constexpr double kLean = 2e-3;  // m: five boxes on 20 iterations
  for (int i = 0; i < 5; ++i) EXPECT_LT((bench.position(boxes[i]) - Vector3(0, 0, 0.5 + i)).norm(), kLean) << i;
}

TEST(OdeBackend, HoldsABoxByTheDirectSolverToo) {
  Bench bench(With(Solver::kDirect));
  bench.AddGround();
  const EntityRow box = bench.Add(kUnitBox, {0, 0, 0.5});

  bench.Run(2);

  EXPECT_LT((bench.position(box) - Vector3(0, 0, 0.5)).norm(), kRestError);
}

TEST(OdeBackend, SolvesAPileIterativelyThatIsTooLargeForTheDirectSolver) {
  Bench direct(With(Solver::kDirect));
  Bench iterative(With(Solver::kIterative));
  for (Bench* bench : {&direct, &iterative}) {
    bench->AddGround();
    for (int i = 0; i < 30; ++i) bench->Add(kUnitBox, {0.999 * i, 0, 0.499});
    for (int i = 0; i < 5; ++i) bench->Step();
  }

  EXPECT_EQ(direct.state.positions, iterative.state.positions);
}

TEST(OdeBackend, SolvesBodiesIterativelyThatAreTooUnequalForTheDirectSolver) {
  // On either side of the spread of 1e9 that the direct solver is given.
  for (const auto& [mass, is_direct] : {std::pair(1e-6, true), std::pair(1e-10, false)}) {
    Bench direct(With(Solver::kDirect));
    Bench iterative(With(Solver::kIterative));
    for (Bench* bench : {&direct, &iterative}) {
      bench->AddGround();
      bench->Add(kUnitBox, {0, 0, 0.49});
      RigidBody light = Bench::BodyOf(kUnitBox);
      light.inertia.mass = mass;
      bench->Add(light, {{0, 0, 1.48}, Quaternion::Identity()});
      for (int i = 0; i < 5; ++i) bench->Step();
    }

    EXPECT_EQ(direct.state.positions != iterative.state.positions, is_direct) << mass;
  }
}

TEST(OdeBackend, ThrowsABallOffTheEdgeOfABox) {
  Bench bench;
  bench.AddGround();
  bench.Add(kUnitBox, {0, 0, 0.5}, MotionType::kStatic);
  const EntityRow ball = bench.Add(kUnitBall, {0.7, 0, 2});

  bench.Run(3);

  EXPECT_GT(bench.position(ball).x(), 1);
  EXPECT_NEAR(bench.position(ball).y(), 0, kRestError);
  EXPECT_NEAR(bench.position(ball).z(), 0.5, kRestError);
}

TEST(OdeBackend, BrakesASlideAlikeInEveryDirection) {
  constexpr double kSpeed = 3;
  // From the order of the method: half a step of the initial speed, on a way of 0.92 m.
  constexpr double kDistanceError = 1.5e-2;
  for (const double heading : {0.0, 0.3, M_PI / 4, 2.0}) {
    Bench bench;
    bench.AddGround();
    RigidBody body = Bench::BodyOf(Box{{0.5, 0.5, 0.1}});
    body.linear_velocity = {kSpeed * std::cos(heading), kSpeed * std::sin(heading), 0};
    const EntityRow box = bench.Add(body, {{0, 0, 0.1}, Quaternion::Identity()});

    bench.Run(2);

    const double expected = kSpeed * kSpeed / (2 * bench.friction * kGravity);
    const Vector3 way = bench.position(box);
    EXPECT_NEAR(way.head<2>().norm() / expected, 1, kDistanceError) << heading;
    EXPECT_NEAR(std::remainder(std::atan2(way.y(), way.x()) - heading, 2 * M_PI), 0, 1e-3) << heading;
  }
}

TEST(OdeBackend, CarriesABodyOnAKinematicOne) {
  Bench bench;
  RigidBody belt = Bench::BodyOf(Box{{5, 5, 0.5}}, MotionType::kKinematic);
  belt.linear_velocity = {1, 0.5, 0};
  bench.Add(belt, {});
  const EntityRow box = bench.Add(Box{{0.5, 0.5, 0.1}}, {0, 0, 0.6});

  bench.Run(1);

  EXPECT_LT((bench.velocity(box) - Vector3(1, 0.5, 0)).norm(), kRestError);
}

TEST(OdeBackend, IsLiftedByAKinematicBodyOfWhateverOrder) {
  for (const bool lift_is_first : {true, false}) {
    Bench bench;
    bench.friction = 0;
    RigidBody lift = Bench::BodyOf(Box{{5, 5, 0.5}}, MotionType::kKinematic);
    lift.linear_velocity = {0, 0, 0.25};
    if (lift_is_first) bench.Add(lift, {});
    const EntityRow box = bench.Add(kUnitBox, {0, 0, 1});
    if (!lift_is_first) bench.Add(lift, {});

    bench.Step();

    EXPECT_NEAR(bench.velocity(box).z(), 0.25, kRestError) << lift_is_first;
  }
}

TEST(OdeBackend, DoesNotHopAfterAHardLanding) {
  Bench bench;
  bench.AddGround();
  const EntityRow ball = bench.Add(kUnitBall, {0, 0, 5});
  // m: what the speed that takes away an overlap carries a body up.
  constexpr double kHop = 5e-3;
  bool has_landed = false;
  for (int i = 0; i < 360; ++i) {
    bench.Step();
    has_landed |= bench.position(ball).z() < 0.5;
    if (!has_landed) continue;
    EXPECT_LT(bench.position(ball).z(), 0.5 + kHop);
  }

  EXPECT_TRUE(has_landed);
}

TEST(OdeBackend, PushesNothingForASensor) {
  Bench bench;
  RigidBody zone = Bench::BodyOf(kUnitBox, MotionType::kStatic);
  zone.geometries[0].is_sensor = true;
  bench.Add(zone, {});
  const EntityRow ball = bench.Add(kUnitBall, {0, 0, 0.2});

  bench.Step();

  ASSERT_EQ(bench.contacts.pairs.size(), 1u);
  EXPECT_TRUE(bench.contacts.pairs[0].is_sensor);
  EXPECT_EQ(TotalImpulse(bench.contacts), 0);
  EXPECT_DOUBLE_EQ(bench.velocity(ball).z(), -kGravity * kStep);
}

TEST(OdeBackend, LetsAnInactiveBodyCarryAnActiveOne) {
  Bench bench;
  const EntityRow sleeper = bench.Add(kUnitBox, {0, 0, 0.5});
  const EntityRow box = bench.Add(kUnitBox, {0, 0, 1.5});
  bench.SetActive(sleeper, false);

  bench.Run(1);

  EXPECT_EQ(bench.position(sleeper), Vector3(0, 0, 0.5));
  EXPECT_NEAR(bench.position(box).z(), 1.5, kRestError);
}

void BuildHeap(Bench& bench) {
  bench.AddGround();
  for (int i = 0; i < 27; ++i) {
    const Vector3 place(0.9 * (i % 3), 0.9 * (i / 3 % 3), 0.6 + 1.1 * (i / 9));
    bench.Add(i % 2 == 0 ? Shape{Box{{0.4, 0.35, 0.45}}} : Shape{Sphere{0.4}}, place);
  }
}

TEST(OdeBackend, GivesTwoWorldsOnTwoThreadsTheBitsTheyHaveAlone) {
  Bench alone, left, right;
  for (Bench* bench : {&alone, &left, &right}) BuildHeap(*bench);
  alone.Run(2);

  std::thread other([&] { left.Run(2); });
  right.Run(2);
  other.join();

  EXPECT_EQ(left.state.positions, alone.state.positions);
  EXPECT_EQ(right.state.positions, alone.state.positions);
  EXPECT_GT(alone.contacts.points.size(), 20u);
  std::string alone_bytes, left_bytes;
  alone.world().SaveState(alone_bytes);
  left.world().SaveState(left_bytes);
  EXPECT_EQ(left_bytes, alone_bytes);
}

TEST(OdeBackend, GivesTheSameBitsWhateverWasThereBefore) {
  Bench plain, used;
  BuildHeap(plain);
  used.moving.reserve(1);
  BuildHeap(used);
  // Bodies that come and go, sleep and wake leave no trace.
  for (int i = 0; i < 100; ++i) {
    const EntityRow guest = used.Add(kUnitBall, {100, 0, 10.0 * i});
    used.moving.pop_back();
    used.Remove(guest);
  }
  const std::vector<EntityRow> all = used.moving;
  for (EntityRow row : all) used.SetActive(row, false);
  for (auto row = all.rbegin(); row != all.rend(); ++row) used.SetActive(*row, true);

  plain.Run(2);
  used.Run(2);

  EXPECT_EQ(used.state.positions.leftCols(plain.state.rows()), plain.state.positions);
}

TEST(OdeBackend, FaultsAWorldThatIsNotFiniteAndNoOther) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Bench good, bad;
  BuildHeap(good);
  BuildHeap(bad);
  const EntityRow row = bad.moving[3];

  EXPECT_THROW(bad.Move(row, {kNan, 0, 0}), EngineFault);
  bad.Move(row, {100, 0, 0});
  bad.state.angular_velocities(1, Index(row)) = kNan;
  EXPECT_THROW(bad.Step(), EngineFault);

  good.Run(0.5);
  EXPECT_TRUE(good.state.positions.allFinite());
}

TEST(OdeBackend, SurvivesAFaultInTheMidstOfAStep) {
#ifdef __SANITIZE_ADDRESS__
  // The job that throws is on none of ODE's lists any more, so nobody can free it.
  const __lsan::ScopedDisabler leaks_are_known;
#endif
  for (int i = 0; i < 20; ++i) {
    Bench bad({.solver = Solver::kDirect});
    bad.AddGround();
    for (int box = 0; box < 4; ++box) bad.Add(kUnitBox, {0, 0, 0.5 + box});
    bad.Run(0.1);
    // Its square is infinite, which ODE's own assertions find.
    bad.state.angular_velocities(1, Index(bad.moving[2])) = 1e200;
    EXPECT_THROW(bad.Step(), EngineFault);
  }
  Bench good;
  BuildHeap(good);
  good.Run(0.5);
  EXPECT_TRUE(good.state.positions.allFinite());
}

}  // namespace
}  // namespace genphys

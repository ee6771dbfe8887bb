// What contacts owe to whoever knows no more than a ball and a floor: the smallest of engines is held to it as well.
#include <algorithm>
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/tolerances.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Spheres, Claim::kContactImpulses);

constexpr double kGravity = 9.81;

struct Mean {
  double normal = 0;
  Vector3 friction = Vector3::Zero();
};

// N*s per step that the floor passed on to what lies on it.
Mean MeanImpulse(World& world) {
  constexpr int kSteps = 60;
  world.TakeEvents();
  Steps(world, kSteps);
  Mean mean;
  for (const ContactPersisted& contact : Of<ContactPersisted>(world.TakeEvents())) {
    for (const EventContactPoint& point : contact.points) {
      mean.normal += point.normal_impulse / kSteps;
      mean.friction += point.friction_impulse / kSteps;
    }
  }
  return mean;
}

// A world whose floor is a slope of `incline` rad down `along`, which is told by what falls and not by the floor.
std::unique_ptr<World> MakeSlope(const std::string& engine, double incline, const Vector3& along = Vector3::UnitX()) {
  const Vector3 down = std::sin(incline) * along - std::cos(incline) * Vector3::UnitZ();
  WorldDesc desc{.engine = engine, .gravity = kGravity * down};
  desc.recorded_events.persisting_contacts = true;
  desc.default_auto_disable.enabled = false;
  return testing::MakeWorld(desc);
}

TEST_P(Spheres, PushTheFloorWithTheirWeight) {
  for (const double mass : {1e-2, 1.0, 1e3}) {
    const auto world = MakeSlope(GetParam(), 0);
    Add(*world, Ball({0, 0, 0.5}, 0.5, mass));
    Steps(*world, 60);
    EXPECT_NEAR(MeanImpulse(*world).normal / (mass * kGravity / 60), 1, kSwept) << "mass " << mass;
  }
}

TEST_P(Spheres, AreTurnedByWhatHoldsThemOnASlope) {
  Proves({Claim::kStaticFriction});
  constexpr double kIncline = 0.2;
  // Askew to whatever axes an engine may have.
  const Vector3 along(0.8, -0.6, 0);
  const Vector3 across(0.6, 0.8, 0);
  const auto world = MakeSlope(GetParam(), kIncline, along);
  const EntityId ball = Add(*world, Ball({0, 0, 0.5}));
  Steps(*world, 30);
  const Mean mean = MeanImpulse(*world);
  // A ball rolls with five sevenths of what pulls it along; the floor holds back the rest.
  const double pull = kGravity * std::sin(kIncline);
  EXPECT_NEAR(mean.friction.dot(along) / (-2.0 / 7 * pull / 60), 1, kSwept);
  EXPECT_NEAR(mean.friction.dot(across), 0, kSwept * pull / 60);
  EXPECT_NEAR(VelocityOf(*world, ball).dot(along) / (5.0 / 7 * pull * 1.5), 1, kSwept);
}

TEST_P(Spheres, TouchAcrossTheGapOfATouchAndNoWiderOne) {
  const Vector3 along = Vector3(2, -1, 2) / 3;
  for (const double gap : {kTouch / 2, 2 * kTouch}) {
    SCOPED_TRACE(gap);
    const auto world = testing::MakeWorld({.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = true});
    Add(*world, Ball({0, 0, 0.5 + gap}));
    Add(*world, Ball({0, 0, 5}));
    Add(*world, Ball(Vector3(0, 0, 5) + (1 + gap) * along));
    Steps(*world, 1);
    const auto began = Of<ContactBegan>(world->TakeEvents());
    ASSERT_EQ(began.size(), gap < kTouch ? 2 : 0);
    // Nobody pulls, so that nobody moves. Each is told half-way between the surfaces.
    for (const ContactBegan& contact : began) {
      const bool is_floor = &contact == &began[0];
      const Vector3 half_way = is_floor ? Vector3(0, 0, gap / 2) : Vector3(Vector3(0, 0, 5) + (1 + gap) / 2 * along);
      ASSERT_EQ(contact.points.size(), 1);
      EXPECT_LE((contact.points[0].position - half_way).norm(), 10 * kRounded);
      EXPECT_NEAR(contact.points[0].depth, -gap, 10 * kRounded);
    }
  }
}

TEST_P(Spheres, CloseAGapAndNoMore) {
  const auto world = MakeSlope(GetParam(), 0);
  for (const double gap : {1e-4, 5e-4, 2e-3, 1e-2}) {
    const EntityId ball = Add(*world, Ball({1000 * gap, 0, 0.5 + gap}, 0.5));
    Steps(*world, 60);
    EXPECT_NEAR(PositionOf(*world, ball).z(), 0.5, kTouch) << "gap " << gap;
    EXPECT_NEAR(VelocityOf(*world, ball).norm(), 0, SweptSpeed(kGravity, SubstepOf(*world))) << "gap " << gap;
    Do(*world, DeleteEntity{ball});
  }
}

TEST_P(Spheres, StayWhereTheirAxesAreLockedWhateverTheyTouch) {
  Proves({Claim::kLockedAxes});
  const auto world = MakeSlope(GetParam(), 0.7);
  EntityDesc desc = Ball({0, 0, 0.5});
  desc.rigid_body->locked_axes.linear[0] = true;
  const EntityId held = Add(*world, desc);
  desc = Ball({0, 3, 0.5});
  desc.rigid_body->locked_axes.angular[1] = true;
  const EntityId slides = Add(*world, desc);
  Steps(*world, 60);
  EXPECT_EQ(PositionOf(*world, held).x(), 0) << "not a bit";
  EXPECT_GT(PositionOf(*world, slides).x(), 0.1);
  EXPECT_EQ(SpinOf(*world, slides).y(), 0) << "it does not roll";
}

TEST_P(Spheres, LieOnOneThatIsHeldInTheAir) {
  Proves({Claim::kLockedAxes});
  const auto world = MakeSlope(GetParam(), 0);
  EntityDesc desc = Ball({0, 0, 2});
  desc.rigid_body->locked_axes.linear = {true, true, true};
  Add(*world, desc);
  desc = Ball({0, 0, 3});
  desc.rigid_body->locked_axes.linear = {true, true, false};
  const EntityId rests = Add(*world, desc);
  Steps(*world, 60);
  EXPECT_NEAR(PositionOf(*world, rests).z(), 3, kTouch);
  EXPECT_NEAR(VelocityOf(*world, rests).z(), 0, SweptSpeed(kGravity, SubstepOf(*world)));
}

TEST_P(Spheres, AreOutOfTheFloorSoonIfTheyBeginInIt) {
  constexpr double kSpeed = 0.3, kPart = 0.2;
  const auto world = MakeSlope(GetParam(), 0);
  double allowed = 0.05;
  const EntityId ball = Add(*world, Ball({0, 0, 0.5 - allowed}));
  const double substep = SubstepOf(*world);
  for (int step = 1; step <= 60; ++step) {
    Steps(*world, 1);
    for (double time = 0; time < (1 - 1e-9) / 60; time += substep) {
      allowed -= std::min(kPart * allowed, kSpeed * substep);
    }
    EXPECT_LE(0.5 - PositionOf(*world, ball).z(), allowed + kTouch) << "step " << step;
  }
}

// The floor, made after those who lie on it, so that it comes second in every pair.
void AddFloor(World& world, const Vector3& surface_velocity = Vector3::Zero(), const Material& material = {}) {
  Geometry floor{.shape = Plane{}, .material = material};
  floor.surface_velocity = surface_velocity;
  EntityDesc desc;
  desc.rigid_body = RigidBody{.motion_type = MotionType::kStatic, .geometries = {floor}};
  Add(world, desc);
}

std::unique_ptr<World> MakeUnfloored(const std::string& engine) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .ground_plane = false};
  desc.recorded_events.persisting_contacts = true;
  desc.default_auto_disable.enabled = false;
  return testing::MakeWorld(desc);
}

TEST_P(Spheres, LieOnAFloorThatCameAfterThem) {
  Proves({Claim::kPlane});
  const auto world = MakeUnfloored(GetParam());
  const EntityId ball = Add(*world, Ball({0, 0, 0.5}, 0.5, 3));
  AddFloor(*world);
  Steps(*world, 60);
  EXPECT_NEAR(PositionOf(*world, ball).z(), 0.5, kTouch);
  EXPECT_NEAR(MeanImpulse(*world).normal / (3 * kGravity / 60), 1, kSwept);
}

TEST_P(Spheres, AreCarriedByAFloorThatRunsWhicheverCameFirst) {
  Proves({Claim::kSurfaceVelocity});
  constexpr double kSpeed = 2;
  for (const bool floor_first : {true, false}) {
    const auto world = MakeUnfloored(GetParam());
    const Vector3 run(0, kSpeed, 0);
    if (floor_first) AddFloor(*world, run);
    const EntityId ball = Add(*world, Ball({0, 0, 0.5}));
    if (!floor_first) AddFloor(*world, run);
    Steps(*world, 60);
    const double slip = 2 * SweptSpeed(0.5 * kGravity, SubstepOf(*world));
    // The angular momentum about the surface stays nothing: m v r = 2/5 m r^2 w, and v + w r is the floor's speed.
    EXPECT_NEAR(VelocityOf(*world, ball).y(), 2 * kSpeed / 7, slip) << floor_first;
    EXPECT_NEAR(VelocityOf(*world, ball).x(), 0, slip) << floor_first;
  }
}

TEST_P(Spheres, RollToAStopWhicheverCameFirst) {
  Proves({Claim::kRollingFriction});
  constexpr double kSpeed = 2, kArm = 0.04, kRadius = 0.5;
  // m v' = -f and I w' = f r - arm N, with v = w r.
  constexpr double kBraking = kArm / kRadius * kGravity / 1.4;
  for (const bool floor_first : {true, false}) {
    const auto world = MakeUnfloored(GetParam());
    const Material rough{.friction = 0.5, .rolling_friction = kArm};
    if (floor_first) AddFloor(*world, Vector3::Zero(), rough);
    EntityDesc rolling = Ball({0, 0, kRadius}, kRadius);
    rolling.rigid_body->geometries[0].material = rough;
    rolling.rigid_body->linear_velocity = {kSpeed, 0, 0};
    rolling.rigid_body->angular_velocity = {0, kSpeed / kRadius, 0};
    const EntityId ball = Add(*world, rolling);
    if (!floor_first) AddFloor(*world, Vector3::Zero(), rough);
    Steps(*world, static_cast<int>(1.2 * 60 * kSpeed / kBraking));
    // As in Rolling.ABallStopsWhereTheClosedFormSaysWhateverItsHeading.
    EXPECT_NEAR(PositionOf(*world, ball).x(), kSpeed * kSpeed / (2 * kBraking), 2 * kSpeed * SubstepOf(*world))
        << floor_first;
    EXPECT_LE(VelocityOf(*world, ball).norm(), SweptSpeed(kGravity, SubstepOf(*world))) << floor_first;
  }
}

// A dumbbell of unequal balls, the same in the world however its own frame lies in it.
EntityDesc Dumbbell(const Pose& in_world, const Pose& frame) {
  EntityDesc desc = Ball(Vector3::Zero(), 0.3);
  RigidBody& body = *desc.rigid_body;
  body.geometries.resize(2, body.geometries[0]);
  body.geometries[1].shape = Sphere{0.2};
  const Quaternion back = frame.orientation.conjugate();
  for (const auto& [place, x] : {std::pair(0, -0.4), std::pair(1, 0.5)}) {
    body.geometries[static_cast<size_t>(place)].pose_in_entity.position = back * (Vector3(x, 0, 0) - frame.position);
  }
  desc.pose = {in_world.Transform(frame.position), in_world.orientation * frame.orientation};
  return desc;
}

TEST_P(Spheres, InPairsMoveAlikeHoweverTheirFramesLie) {
  Proves({Claim::kCompound, Claim::kFreeRotation});
  // It falls askew onto its smaller ball, tumbles over and rolls.
  const Pose start{{0, 0, 0.9}, Quaternion(Eigen::AngleAxisd(0.8, Vector3(0.2, 1, 0.4).normalized()))};
  const auto end_of = [&](const Pose& frame) {
    const auto world = MakeSlope(GetParam(), 0);
    EntityDesc desc = Dumbbell(start, frame);
    desc.rigid_body->angular_velocity = {0.5, -0.3, 1};
    desc.rigid_body->linear_velocity = {0.3, 0.1, 0};
    const EntityId id = Add(*world, desc);
    Steps(*world, 50);
    const Pose pose = world->state().pose(EntityRow{id.index()});
    return pose.Transform(frame.orientation.conjugate() * (Vector3(0.5, 0, 0) - frame.position));
  };
  const Vector3 plain = end_of({});
  for (const Pose& frame :
       {Pose{{0, 0, 1}, Quaternion::Identity()},
        Pose{{0.3, -0.2, 0.4}, Quaternion(Eigen::AngleAxisd(1.9, Vector3(1, 2, -1).normalized()))}}) {
    // Of each of the two ways sweeps may leave a part.
    EXPECT_LE((end_of(frame) - plain).norm(), 2 * kSwept * (plain - start.Transform({0.5, 0, 0})).norm());
  }
}

TEST_P(Spheres, FeelForcesInColumnsAndTellWhatTheyFelt) {
  Proves({Claim::kForceColumns, Claim::kNetForce});
  const auto world = MakeSlope(GetParam(), 0);
  const EntityId lies = Add(*world, Ball({0, 0, 0.5})), pushed = Add(*world, Ball({3, 0, 5}, 0.5, 2));
  Steps(*world, 30);
  const double speed = VelocityOf(*world, pushed).z();
  Do(*world, ApplyForceColumns{.ids = {pushed}, .forces = {{4, 0, 0}}, .torques = {}});
  Steps(*world, 1);
  EXPECT_NEAR(VelocityOf(*world, pushed).x(), 4.0 / 2 / 60, kRounded);
  EXPECT_NEAR(VelocityOf(*world, pushed).z(), speed - kGravity / 60, kRounded);
  const auto& net = world->state().net_forces;
  EXPECT_NEAR((net.col(pushed.index()) - Vector3(4, 0, -2 * kGravity)).norm(), 0, 2 * kGravity * kRounded);
  EXPECT_NEAR(net.col(lies.index()).norm(), 0, kGravity * kSwept);
}

TEST_P(Spheres, ArePushedAtTheSpeedOfWhatPushesThem) {
  Proves({Claim::kKinematicPush});
  const auto world = MakeSlope(GetParam(), 0);
  const EntityId ball = Add(*world, Ball({0, 0, 0.5}));
  EntityDesc pusher = Ball({-1, 0, 0.5});
  pusher.rigid_body->motion_type = MotionType::kKinematic;
  pusher.rigid_body->linear_velocity = {1, 0, 0};
  // Nothing turns the ball up along the pusher.
  pusher.rigid_body->geometries[0].material.friction = 0;
  Add(*world, pusher);
  Steps(*world, 60);
  EXPECT_NEAR(PositionOf(*world, ball).x(), 1, 1e-3) << "promised";
}

TEST_P(Spheres, SlideWithKineticFrictionUntilTheyRoll) {
  Proves({Claim::kKineticFriction, Claim::kSolverIterative});
  constexpr double kKinetic = 0.2, kSpeed = 5;
  WorldDesc desc{.engine = GetParam(),
                 .gravity = {0, 0, -kGravity},
                 .stepper = {.solver = Solver::kIterative},
                 .default_material = {.friction = 0.8, .kinetic_friction = kKinetic}};
  const auto world = testing::MakeWorld(desc);
  EntityDesc thrown = Ball({0, 0, 0.5});
  thrown.rigid_body->linear_velocity = {kSpeed, 0, 0};
  const EntityId ball = Add(*world, thrown);
  Steps(*world, 15);
  EXPECT_NEAR(VelocityOf(*world, ball).x(), kSpeed - kKinetic * kGravity / 4, 2 * kSwept * kKinetic * kGravity / 4);
  Steps(*world, 60);
  EXPECT_NEAR(VelocityOf(*world, ball).x(), 5.0 / 7 * kSpeed, 2 * SweptSpeed(0.8 * kGravity, SubstepOf(*world)));
}

// What sweeps is given the rows of all joints, whatever these hold; else the layer solves them where nothing touches.
std::unique_ptr<World> MakeSweptSpace(const std::string& engine) {
  return MakeSpace(engine, {.solver = Solver::kIterative}, Vector3::Zero());
}

// A slider along x between two balls of `mass` kg, 2 m apart.
JointId JoinAlongX(World& world, double mass, const JointAxis& axis) {
  const EntityId a = Add(world, Ball({0, 0, 0}, 0.5, mass)), b = Add(world, Ball({2, 0, 0}, 0.5, mass));
  JointDesc slider = Between(a, b, SliderJoint{axis}, FrameAlong({1, 0, 0}));
  slider.frame_in_b = FrameAlong({1, 0, 0});
  return Join(world, slider);
}

TEST_P(Spheres, ArePulledTogetherAsHardAsAMotorMay) {
  Proves({Claim::kJointSlider, Claim::kSolverIterative});
  constexpr double kForce = 3, kMass = 2, kTime = 0.5;
  const auto world = MakeSweptSpace(GetParam());
  const JointId id = JoinAlongX(*world, kMass, {.motor = Motor{.target_velocity = -100, .force_max = kForce}});
  Steps(*world, 30);
  EXPECT_NEAR(StateOf(*world, id).rates[2] / (-2 * kForce / kMass * kTime), 1, kSwept);
  EXPECT_NEAR(StateOf(*world, id).positions[2] / (2 - kForce / kMass * kTime * kTime), 1, kSwept);
}

TEST_P(Spheres, SwingOnASpringBetweenThem) {
  Proves({Claim::kJointSlider, Claim::kSolverIterative});
  constexpr double kStiffness = 9, kMass = 2, kRest = 1.5, kTime = 1;
  const auto world = MakeSweptSpace(GetParam());
  const JointId id = JoinAlongX(*world, kMass, {.spring = Spring{.stiffness = kStiffness, .rest = kRest}});
  Steps(*world, 60);
  // Newmark's method with beta 1/4 swings slower by a twelfth of the square of what it goes in a step.
  const double pace = std::sqrt(2 * kStiffness / kMass), turn = pace * SubstepOf(*world);
  const double late = pace * kTime * turn * turn / 12 + kSwept;
  EXPECT_NEAR(StateOf(*world, id).positions[2], kRest + 0.5 * std::cos(pace * kTime), 2 * 0.5 * late);
}

TEST_P(Spheres, TurnEachOtherByAGear) {
  Proves({Claim::kJointGear, Claim::kSolverIterative});
  constexpr double kRatio = -2.5, kTorque = 0.2;
  const auto world = MakeSweptSpace(GetParam());
  const EntityId a = Add(*world, Ball({0, 0, 0}, 0.5, 2)), b = Add(*world, Ball({2, 0, 0}, 0.3, 1));
  Join(*world, ToWorld(a, HingeJoint{}));
  Join(*world, ToWorld(b, HingeJoint{}, Pose{{2, 0, 0}, Quaternion::Identity()}));
  Join(*world, Between(a, b, GearJoint{.ratio = kRatio}));
  Do(*world, ApplyForce{.id = a, .torque = {0, 0, kTorque}, .steps = 60});
  Steps(*world, 60);
  const double expected = kTorque / (0.4 * 2 * 0.25 + kRatio * kRatio * 0.4 * 0.09);
  EXPECT_NEAR(SpinOf(*world, a).z() / expected, 1, kSwept);
  EXPECT_NEAR(SpinOf(*world, b).z() / (kRatio * expected), 1, kSwept);
}

TEST_P(Spheres, AreAllHitByARayThroughThem) {
  Proves({Claim::kRaysThrough});
  const auto world = MakeSlope(GetParam(), 0);
  const EntityId near = Add(*world, Ball({2, 0, 0.5})), far = Add(*world, Ball({6, 0, 0.5}));
  const std::vector<Ray> rays{{{0, 0, 0.5}, {10, 0, 0}}};
  const auto answer = world->CastRaysThrough(rays);
  EndAtRefusal(answer.status());
  ASSERT_TRUE(answer.ok() && answer->front().size() == 2);
  EXPECT_EQ(answer->front()[0].hit.entity, near);
  EXPECT_EQ(answer->front()[1].hit.entity, far);
  EXPECT_NEAR(answer->front()[1].fraction, 0.55, kRounded);
}

}  // namespace
}  // namespace genphys::testing

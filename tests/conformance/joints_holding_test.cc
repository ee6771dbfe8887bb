// What joints hold: periods, weights, cantilevers.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsHolding);

constexpr double kGravity = 9.81;

double PeriodOf(World& world, EntityId id, int steps) {
  double first = 0, last = 0, before = PositionOf(world, id).x();
  int swings = -1;
  for (int i = 0; i < steps; ++i) {
    Steps(world, 1);
    const double x = PositionOf(world, id).x();
    if (before < 0 && x >= 0) {
      last = (i - before / (x - before)) * world.scene().world.stepper.step_size;
      if (++swings == 0) first = last;
    }
    before = x;
  }
  return (last - first) / swings;
}

TEST_P(JointsHolding, APendulumHasThePeriodOfTheClosedForm) {
  Proves({Claim::kJointBall, Claim::kJointHinge, Claim::kJointDistance});
  constexpr double kAngle = 0.2, kRadius = 0.1;
  for (const JointKind& kind : {JointKind(BallJoint{}), JointKind(HingeJoint{}), JointKind(DistanceJoint{})}) {
    const auto world = MakeSpace(GetParam());
    const EntityId ball = Add(*world, Ball({std::sin(kAngle), 0, -std::cos(kAngle)}, kRadius));
    const bool is_rod = std::holds_alternative<DistanceJoint>(kind);
    Join(*world, ToWorld(ball, kind, FrameAlong(Vector3::UnitY())));

    const double period = PeriodOf(*world, ball, 1200);

    // A rod does not turn the ball.
    const double inertia = 1 + (is_rod ? 0 : 0.4 * kRadius * kRadius);
    const double small = 2 * M_PI * std::sqrt(inertia / kGravity);
    const double exact = small * (1 + std::pow(kAngle, 2) / 16 + 11 * std::pow(kAngle, 4) / 3072);
    // Of the symplectic Euler method: (w h)^2 / 24.
    const double predicted = std::pow(2 * M_PI / exact * SubstepOf(*world), 2) / 24;
    EXPECT_NEAR(period, exact, 2 * predicted * exact) << "kind " << kind.index();
  }
}

// Its angle to the rod that hangs from above (rad), that of what hangs at the end of that, and both rates.
using Rods = Eigen::Vector4d;

// A body that hangs on a rod without mass, by a point that is `arm` above its centre: a double pendulum.
struct HungOff {
  double rod = 0.5, arm = 0.1, mass = 2, gravity = 9.81;
  Box box{{0.1, 0.1, 0.3}};

  Rods RateOf(const Rods& s) const {
    const double inertia = mass / 3 * (box.half_extents.x() * box.half_extents.x() + 0.3 * 0.3);
    const double along = std::cos(s[0] - s[1]), across = std::sin(s[0] - s[1]);
    const double shared = mass * rod * arm;
    Eigen::Matrix2d masses;
    masses << mass * rod * rod, shared * along, shared * along, mass * arm * arm + inertia;
    const Eigen::Vector2d forces(-shared * across * s[3] * s[3] - mass * gravity * rod * std::sin(s[0]),
                                 shared * across * s[2] * s[2] - mass * gravity * arm * std::sin(s[1]));
    Rods rate;
    rate << s.tail<2>(), masses.inverse() * forces;
    return rate;
  }
  Vector3 CenterAt(const Rods& s) const {
    return {rod * std::sin(s[0]) + arm * std::sin(s[1]), 0, -rod * std::cos(s[0]) - arm * std::cos(s[1])};
  }
};

// How far from where a double pendulum is after `time` s, m.
double HungOffError(const std::string& engine, int rate, Rods s, double time) {
  const HungOff hung;
  const Rods begin = s;
  constexpr int kReferenceSteps = 20'000;
  const double h = time / kReferenceSteps;
  for (int i = 0; i < kReferenceSteps; ++i) {
    const Rods a = hung.RateOf(s), b = hung.RateOf(s + h / 2 * a), c = hung.RateOf(s + h / 2 * b);
    s += h / 6 * (a + 2 * b + 2 * c + hung.RateOf(s + h * c));
  }
  const auto world = MakeSpace(engine, {.step_size = 1.0 / rate});
  EntityDesc body = Body(hung.box, hung.CenterAt(begin), hung.mass);
  body.pose.orientation = Eigen::AngleAxisd(-begin[1], Vector3::UnitY());
  const EntityId id = Add(*world, body);
  JointDesc joint = ToWorld(id, DistanceJoint{});
  joint.frame_in_b = Pose{{0, 0, hung.arm}, Quaternion::Identity()};
  Join(*world, joint);
  Steps(*world, static_cast<int>(std::lround(time * rate)));
  return (PositionOf(*world, id) - hung.CenterAt(s)).norm();
}

TEST_P(JointsHolding, ARodThatTurnsFastWhileItsBodyDoesNotIsOfSecondOrder) {
  Proves({Claim::kJointDistance});
  for (const double angle : {-1.5, -0.5, 0.5, 1.5, 2.5}) {
    const auto error = [&](int rate) { return HungOffError(GetParam(), rate, {2.2, angle, 0, 0}, 1.5); };
    const double coarse = error(240);
    EXPECT_LT(coarse, 2e-4) << angle;  // before lines counted: up to 1.1e-3
    EXPECT_LT(error(480), coarse / 3.5) << angle;
  }
}

TEST_P(JointsHolding, AHangingChainCarriesAtEachJointWhatHangsBelow) {
  Proves({Claim::kJointBall});
  constexpr int kLinks = 10;
  const auto world = MakeSpace(GetParam());
  std::vector<JointId> joints;
  EntityId above;
  for (int i = 0; i < kLinks; ++i) {
    const EntityId link = Add(*world, Body(Capsule{0.05, 0.15}, {0, 0, -0.4 * i - 0.2}));
    joints.push_back(Join(*world, Between(above, link, BallJoint{}, Pose{{0, 0, i == 0 ? 0 : -0.2}, {1, 0, 0, 0}})));
    above = link;
  }
  Steps(*world, 60);
  for (int i = 0; i < kLinks; ++i) {
    const double weight = (kLinks - i) * kGravity;
    EXPECT_NEAR(StateOf(*world, joints[static_cast<size_t>(i)]).force.z(), weight, kDirect * weight) << "joint " << i;
  }
}

TEST_P(JointsHolding, ALongChainHoldsTogetherHoweverItIsSolved) {
  Proves({Claim::kJointBall, Claim::kJointHinge});
  constexpr int kLinks = 40;
  constexpr double kLength = 0.4, kThickness = 0.1;
  const Vector3 along(std::sin(0.5), 0, -std::cos(0.5));
  for (const Solver solver : {Solver::kAutomatic, Solver::kIterative}) {
    for (const JointKind& kind : {JointKind(BallJoint{}), JointKind(HingeJoint{})}) {
      const auto world = MakeSpace(GetParam(), {.solver = solver});
      std::vector<JointId> joints;
      EntityId above;
      for (int i = 0; i < kLinks; ++i) {
        EntityDesc link = Body(Capsule{kThickness / 2, 0.15}, (i + 0.5) * kLength * along);
        link.pose.orientation = Quaternion::FromTwoVectors(-Vector3::UnitZ(), along);
        const EntityId id = Add(*world, link);
        const Vector3 place(0, 0, i == 0 ? 0 : -kLength / 2);
        joints.push_back(Join(*world, Between(above, id, kind, FrameAlong(Vector3::UnitY(), place))));
        above = id;
      }
      const StateArrays& state = world->state();
      double fastest = 0, widest = 0, gap = 0;
      for (int i = 0; i < 300; ++i) {
        Steps(*world, 1);
        fastest = std::max(fastest, state.linear_velocities.colwise().norm().maxCoeff());
        widest = std::max(widest, state.angular_velocities.colwise().norm().maxCoeff());
        for (const JointId joint : joints) gap = std::max(gap, GapOf(*world, joint));
      }
      // The ends of two links go straight on for a substep: round them as they turn, or, where sweeps do not see the
      // rest of the chain, as fast as any of it goes.
      const double speed = solver == Solver::kIterative ? fastest : widest * kLength;
      EXPECT_LE(gap, 2 * OffCircle(speed, SubstepOf(*world), kLength));
      // Nothing can be faster than all of the chain's height makes the end of it.
      EXPECT_LE(fastest, std::sqrt(2 * kGravity * kLinks * kLinks * kLength));
    }
  }
}

TEST_P(JointsHolding, AHeavyEndSwingsOnALightChainWithoutTearingIt) {
  Proves({Claim::kJointBall, Claim::kJointHinge});
  constexpr double kLength = 0.1, kThickness = 0.02;
  for (const auto& [links, ratio, angle] :
       {std::tuple(10, 1e3, 0.5), std::tuple(4, 1e4, 1.2), std::tuple(16, 100.0, 1.0), std::tuple(1, 1e3, 0.8)}) {
    for (const JointKind& kind : {JointKind(BallJoint{}), JointKind(HingeJoint{})}) {
      const auto world = MakeSpace(GetParam());
      const Vector3 along(std::sin(angle), 0, -std::cos(angle));
      const double chain = (links + 1) * kLength;
      std::vector<JointId> joints;
      EntityId above;
      for (int i = 0; i <= links; ++i) {
        const double mass = i < links ? 0.1 : 0.1 * ratio;
        EntityDesc link = Body(Capsule{kThickness / 2, (kLength - kThickness) / 2}, (i + 0.5) * kLength * along, mass);
        if (i == links) link = Ball(chain * along, 0.08, mass);
        link.pose.orientation = Quaternion::FromTwoVectors(-Vector3::UnitZ(), along);
        const EntityId id = Add(*world, link);
        const Vector3 place(0, 0, i == 0 ? 0 : -kLength / 2);
        joints.push_back(Join(*world, Between(above, id, kind, FrameAlong(Vector3::UnitY(), place))));
        above = id;
      }
      // The end has all that it and the links fell for, if they have none of it.
      const double fall = chain * (1 - std::cos(angle)) * (1 + links / ratio / 2);
      const double fastest = std::sqrt(2 * kGravity * fall);
      const double step = SubstepOf(*world), gap = 2 * OffCircle(fastest, step, chain);
      // Relative, of the speed of a swing by steps: (w h)^2 / 8.
      const double faster = 2 * kGravity / chain * step * step / 8;
      for (int i = 0; i < 180; ++i) {
        Steps(*world, 1);
        for (const JointId joint : joints) ASSERT_LE(GapOf(*world, joint), gap) << links << " step " << i;
        ASSERT_LE(VelocityOf(*world, above).norm(), (1 + faster) * fastest) << links << " step " << i;
      }
    }
  }
}

TEST_P(JointsHolding, AnOutsideTorqueIsBalancedByWhatPullsALightLink) {
  Proves({Claim::kJointBall});
  constexpr double kLength = 0.1, kLink = 0.1, kEnd = 100, kTorque = 20, kDamping = 5;
  for (const uint32_t substeps : {1, 2, 3, 4, 8}) {
    SCOPED_TRACE(substeps);
    const auto world = MakeSpace(GetParam(), {.substeps = substeps});
    EntityDesc link = Body(Capsule{0.01, kLength / 2 - 0.01}, {0, 0, -kLength / 2}, kLink);
    EntityDesc end = Ball({0, 0, -2 * kLength}, 0.08, kEnd);
    // So that both come to rest.
    for (EntityDesc* body : {&link, &end})
      body->rigid_body->linear_damping = body->rigid_body->angular_damping = kDamping;
    const EntityId light = Add(*world, link), heavy = Add(*world, end);
    const JointId top = Join(*world, ToWorld(light, BallJoint{}));
    const JointId below = Join(*world, Between(light, heavy, BallJoint{}, Pose{{0, 0, -kLength / 2}, {1, 0, 0, 0}}));
    Do(*world, ApplyForce{.id = light, .torque = {0, -kTorque, 0}, .steps = 1200});
    Steps(*world, 1100);
    // About the upper joint: the weight of the link acts at half of its length, that of the end at all of it.
    const double sine = kTorque / (kGravity * kLength * (kEnd + kLink / 2));
    EXPECT_NEAR(PositionOf(*world, light).x(), kLength / 2 * sine, kDirect * kLength);
    // Damping takes its part of what a substep of gravity brings up.
    const double tolerance = 2 * kDamping * SubstepOf(*world) / 2 * kEnd * kGravity;
    EXPECT_NEAR(StateOf(*world, below).force.z(), kEnd * kGravity, tolerance);
    EXPECT_LE((StateOf(*world, top).force - Vector3(0, 0, (kEnd + kLink) * kGravity)).norm(), tolerance);
  }
}

TEST_P(JointsHolding, AFixedBeamCarriesItsWeightAndItsMoment) {
  Proves({Claim::kJointFixed});
  const auto world = MakeSpace(GetParam());
  const EntityId beam = Add(*world, Body(Box{{1, 0.1, 0.1}}, {1, 0, 0}, 3));
  const JointId joint = Join(*world, ToWorld(beam, FixedJoint{}));
  Steps(*world, 120);

  const double weight = 3 * kGravity;
  EXPECT_LE((StateOf(*world, joint).force - Vector3(0, 0, weight)).norm(), kDirect * weight);
  // The origin of frame b is where the beam is held, one metre from its middle.
  EXPECT_LE((StateOf(*world, joint).torque - Vector3(0, -weight, 0)).norm(), kDirect * weight);
  EXPECT_LE((PositionOf(*world, beam) - Vector3(1, 0, 0)).norm(), kDirect);
}

TEST_P(JointsHolding, ABallStopsAtTheEdgeOfItsCone) {
  Proves({Claim::kJointBall, Claim::kJointLimit});
  constexpr double kSwing = 0.5;
  const auto world = MakeSpace(GetParam());
  // Upside down, so that it falls over as far as it may.
  const EntityId ball = Add(*world, Ball({0.01, 0, 1}, 0.2));
  const JointId joint = Join(*world, ToWorld(ball, BallJoint{.swing_max = kSwing}));
  for (int i = 0; i < 600; ++i) {
    Steps(*world, 1);
    // The turn within a substep is told to second order only: w^2 h^2 / 2 at the speed of a fall by that angle.
    const double speed = SpinOf(*world, ball).norm();
    ASSERT_LE(StateOf(*world, joint).positions[3], kSwing + std::pow(speed * SubstepOf(*world), 2) + kDirect * kSwing)
        << i;
  }
  EXPECT_NEAR(StateOf(*world, joint).positions[3], kSwing, kDirect * kSwing);
}

TEST_P(JointsHolding, ARopeIsSlackUntilItIsTaut) {
  Proves({Claim::kJointDistance});
  constexpr double kLength = 1;
  const auto world = MakeSpace(GetParam());
  const EntityId ball = Add(*world, Ball({0, 0, -0.2}, 0.1));
  DistanceJoint rope;
  rope.axis.limits.upper = kLength;
  const JointId joint = Join(*world, ToWorld(ball, rope));
  Steps(*world, 20);  // a third of a second: half a metre
  EXPECT_EQ(StateOf(*world, joint).force.norm(), 0);
  Steps(*world, 100);
  // Along the rope the rate is exact, so that nothing but rounding and softness is left.
  EXPECT_NEAR(GapOf(*world, joint), kLength, kDirect * kLength);
  EXPECT_NEAR(StateOf(*world, joint).force.z(), kGravity, kDirect * kGravity);
  EXPECT_NEAR(StateOf(*world, joint).positions[0], kLength, kDirect * kLength);
}

TEST_P(JointsHolding, WhatIsJoinedDoesNotCollideUnlessItShall) {
  Proves({Claim::kJoinedPairs});
  for (const bool collide : {false, true}) {
    const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
    Require(*world, Feature::kContacts);
    const EntityId a = Add(*world, Ball({0, 0, 0})), b = Add(*world, Ball({0.9, 0, 0}));
    Steps(*world, 1);
    ASSERT_FALSE(world->contacts().pairs.empty());
    DistanceJoint free;
    free.axis.limits.upper = 100;
    JointDesc joint = Between(a, b, free);
    joint.collide_connected = collide;
    const JointId id = Join(*world, joint);
    Steps(*world, 2);
    EXPECT_EQ(world->contacts().pairs.empty(), !collide);
    Do(*world, DeleteJoint{id});
    Do(*world, SetPose{b, Vector3(0.9, 0, 0), {}});
    Do(*world, SetPose{a, Vector3(0, 0, 0), {}});
    Steps(*world, 1);
    EXPECT_FALSE(world->contacts().pairs.empty()) << "they are strangers again";
  }
}

// A slider keeps a body as it is turned, and a hinge wants it turned otherwise.
TEST_P(JointsHolding, JointsThatContradictEachOtherLeaveTheirWorldUsable) {
  Proves({Claim::kJointHinge, Claim::kJointSlider});
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const auto world = MakeSpace(GetParam());
    const EntityId box = Add(*world, Body(Box{{0.5, 0.5, 0.5}}, random.Vector(1)));
    SliderJoint slider;
    slider.axis.limits = {.lower = 0, .upper = random.Uniform(0.1, 1)};
    Join(*world, ToWorld(box, slider));
    JointDesc hinge = ToWorld(box, HingeJoint{}, {random.Vector(0.5), random.Turn()});
    hinge.frame_in_b = Pose{random.Vector(0.2), random.Turn()};
    Join(*world, hinge);
    for (int step = 0; step < 200; ++step) {
      const Status status = world->Step();
      ASSERT_TRUE(status.ok()) << "world " << i << ", step " << step << ": " << status;
    }
    EXPECT_LE(VelocityOf(*world, box).norm(), kGravity) << "world " << i;
  }
}

// By a whole turn in each substep it seems to stand still at every solve while it flies away from its joint.
TEST_P(JointsHolding, WhatGoesRoundByWholeTurnsComesBackToItsJoint) {
  Proves({Claim::kJointBall, Claim::kJointHinge});
  constexpr double kHalf = 0.5, kFar = 5;
  for (const JointKind& kind : {JointKind(BallJoint{}), JointKind(HingeJoint{})}) {
    for (const double turns : {0.5, 1.0, 1.5, 2.0}) {
      const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
      EntityDesc rod = Body(Capsule{0.1, kHalf - 0.1}, {kFar, 0, -kHalf});
      const Vector3 spin = 2 * M_PI * turns / SubstepOf(*world) * Vector3::UnitY();
      rod.rigid_body->angular_velocity = spin;
      rod.rigid_body->linear_velocity = -spin.cross(kHalf * Vector3::UnitZ());
      const EntityId id = Add(*world, rod);
      JointDesc joint = ToWorld(id, kind, FrameAlong(Vector3::UnitY()));
      joint.frame_in_b = FrameAlong(Vector3::UnitY(), kHalf * Vector3::UnitZ());
      const JointId held = Join(*world, joint);
      Steps(*world, 180);
      EXPECT_LE(GapOf(*world, held), 1e-3) << turns << " turns, kind " << kind.index();
    }
  }
}

TEST_P(JointsHolding, AWheelSpinsByWholeTurnsAsLongAsItIsOnItsAxle) {
  Proves({Claim::kJointHinge});
  for (const double turns : {0.5, 1.0, 2.0}) {
    const auto world = MakeSpace(GetParam());
    EntityDesc wheel = Body(Cylinder{0.3, 0.05}, {0, 0, 0});
    const Vector3 spin = 2 * M_PI * turns / SubstepOf(*world) * Vector3::UnitZ();
    wheel.rigid_body->angular_velocity = spin;
    const EntityId id = Add(*world, wheel);
    Join(*world, ToWorld(id, HingeJoint{}));
    Steps(*world, 60);
    EXPECT_NEAR(SpinOf(*world, id).z(), spin.z(), 1e-6 * spin.z()) << turns << " turns";
  }
}

// What they cannot do the engine has to live with, for what touches something is the engine's.
TEST_P(JointsHolding, JointsThatContradictEachOtherLeaveTheirWorldUsableUnderWhatFallsOnThem) {
  Proves({Claim::kJointHinge, Claim::kJointSlider});
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const auto world = MakeSpace(GetParam());
    Require(*world, Feature::kContacts);
    const EntityId held = Add(*world, Body(Capsule{0.5, 0.5}, {0, 0, 1}));
    const EntityId falling = Add(*world, Body(Box{{0.5, 0.5, 0.5}}, {0, 0, random.Uniform(3, 5)}));
    JointDesc hinge = ToWorld(held, HingeJoint{});
    hinge.frame_in_b =
        Pose{Vector3(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1)), random.Turn()};
    hinge.frame_in_a = Pose{Vector3::Zero(), random.Turn()};
    Join(*world, hinge);
    SliderJoint slider;
    slider.axis.limits = {.lower = random.Uniform(0, 2), .upper = random.Uniform(2, 3)};
    Join(*world, ToWorld(held, slider));
    for (int step = 0; step < 200; ++step) {
      const Status status = world->Step();
      ASSERT_TRUE(status.ok()) << "world " << i << ", step " << step << ": " << status;
    }
    // 3.3 s of free fall give 3.3 g; one half more is for what falls off and is hit by what is held.
    EXPECT_LE(VelocityOf(*world, held).norm(), 5 * kGravity) << "world " << i;
    EXPECT_LE(VelocityOf(*world, falling).norm(), 5 * kGravity) << "world " << i;
  }
}

}  // namespace
}  // namespace genphys::testing

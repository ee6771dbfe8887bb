// What pushes a body, and for how long: alike on every engine, because the layer does it.
#include <algorithm>
#include <array>
#include <cmath>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Forces);

constexpr double kStep = 1.0 / 60;
// Of numbers of some ten.
constexpr double kRounding = 10 * kRounded;

std::unique_ptr<World> Weightless(const std::string& engine) {
  return MakeWorld(WorldDesc{.engine = engine, .gravity = Vector3::Zero(), .ground_plane = false});
}

TEST_P(Forces, AForceActsForItsStepsAndNoLonger) {
  Proves({Claim::kForce});
  const auto world = Weightless(GetParam());
  const EntityId ball = Add(*world, Ball({0, 0, 0}, 0.5, 2));
  Do(*world, ApplyForce{.id = ball, .force = {3, 0, 0}, .steps = 10});

  Steps(*world, 9);
  EXPECT_NEAR(VelocityOf(*world, ball).x(), 1.5 * 9 * kStep, kRounding);
  Steps(*world, 20);

  EXPECT_NEAR(VelocityOf(*world, ball).x(), 1.5 * 10 * kStep, kRounding);
}

// Within a step of where the world ends, or within two.
EntityDesc Rocket(int steps) {
  EntityDesc rocket = Ball({1e7 - 1e5 * kStep * (steps - 0.5), 0, 5}, 0.5, 2);
  rocket.rigid_body->linear_velocity = {1e5, 0, 0};
  return rocket;
}

// A controller that hears of it late goes on sending forces: they are not there when it is put back.
TEST_P(Forces, DoNotWaitForWhoIsOutOfTheWorld) {
  Proves({Claim::kForce, Claim::kForceColumns, Claim::kBounds});
  const Vector3 push(10, 0, 0);
  for (const bool is_anybody_awake : {false, true}) {
    const auto world = Weightless(GetParam());
    const EntityId id = Add(*world, Rocket(1));
    EntityDesc bystander = Ball({0, 50, 5});
    bystander.rigid_body->auto_disable.enabled = !is_anybody_awake;
    Add(*world, bystander);
    Steps(*world, 60);
    ASSERT_EQ(world->IsAtRest(), !is_anybody_awake);
    for (int i = 0; i < 10; ++i) {
      Do(*world, ApplyForce{.id = id, .force = push});
      Do(*world, ApplyForce{.id = id, .force = push, .steps = 100});
      Do(*world, ApplyForce{.id = id, .force = push, .sampled = true});
      Do(*world, ApplyForceColumns{.ids = {id}, .forces = {push}, .torques = {}});
      Steps(*world, 1);
    }

    Do(*world, SetPose{.id = id, .position = Vector3(0, 0, 5)});
    Steps(*world, 2);

    EXPECT_EQ(VelocityOf(*world, id), Vector3(0, 0, 0)) << is_anybody_awake;
    Do(*world, ApplyForce{.id = id, .force = push});
    Steps(*world, 2);
    EXPECT_NEAR(VelocityOf(*world, id).x(), 10 / 2.0 * kStep, kRounding) << "it is back";
  }
}

TEST_P(Forces, AForceBesideTheCentreTurnsTheBody) {
  Proves({Claim::kForce});
  const auto world = Weightless(GetParam());
  const EntityId ball = Add(*world, Ball({1, 2, 3}, 0.5, 2));

  Do(*world, ApplyForce{.id = ball, .force = {0, 4, 0}, .point = Vector3(1.25, 2, 3)});
  Steps(*world, 1);

  // The point turns with the body: in later substeps its arm is shorter by half the square of that angle.
  constexpr double kSpin = 0.25 * 4 * kStep / (0.4 * 2 * 0.25), kTurned = kSpin * kStep;
  EXPECT_NEAR(SpinOf(*world, ball).z(), kSpin, kTurned * kTurned / 2 * kSpin);
  EXPECT_NEAR(VelocityOf(*world, ball).y(), 2 * kStep, kRounding);
}

TEST_P(Forces, CoordinatesOfTheEntityTurnWithIt) {
  Proves({Claim::kForceCoordinates});
  const auto world = Weightless(GetParam());
  EntityDesc ball = Ball({0, 0, 0});
  ball.pose.orientation = Quaternion(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ()));
  const EntityId id = Add(*world, ball);

  Do(*world, ApplyForce{.id = id, .force = {1, 0, 0}, .coordinates = Coordinates::kEntity});
  Steps(*world, 1);

  EXPECT_NEAR(VelocityOf(*world, id).y(), kStep, kRounding);
  EXPECT_NEAR(VelocityOf(*world, id).x(), 0, kRounding);
}

TEST_P(Forces, ReplacingDropsWhatWasPending) {
  Proves({Claim::kForce});
  const auto world = Weightless(GetParam());
  const EntityId ball = Add(*world, Ball({0, 0, 0}));
  Do(*world, ApplyForce{.id = ball, .force = {5, 0, 0}, .steps = 100});

  Do(*world, ApplyForce{.id = ball, .force = {0, 1, 0}, .steps = 1, .replace = true});
  Steps(*world, 3);

  EXPECT_EQ(VelocityOf(*world, ball).x(), 0);
  EXPECT_NEAR(VelocityOf(*world, ball).y(), kStep, kRounding);
}

TEST_P(Forces, ColumnsDoWhatTheSameForcesDoOneByOne) {
  Proves({Claim::kForceColumns});
  const auto one = Weightless(GetParam()), columns = Weightless(GetParam());
  ApplyForceColumns command;
  for (int i = 0; i < 5; ++i) {
    const Vector3 position(3 * i, 0, 0), force(i, 1, -i), torque(0, i, 1);
    const EntityId a = Add(*one, Crate(position));
    command.ids.push_back(Add(*columns, Crate(position)));
    command.forces.push_back(force);
    command.torques.push_back(torque);
    Do(*one, ApplyForce{.id = a, .force = force, .torque = torque});
  }
  Do(*columns, command);

  Steps(*one, 2);
  Steps(*columns, 2);

  EXPECT_EQ(one->state().positions, columns->state().positions);
  EXPECT_EQ(one->state().orientations, columns->state().orientations);
}

// A spring that the client computes before each step. With samples that is the velocity Verlet method, whose places are
// those of an oscillation of slightly another frequency: cos(n a) with sin(a / 2) = w h / 2. Whatever the substeps.
TEST_P(Forces, SampledOnesMoveABodyAsVerletDoes) {
  Proves({Claim::kForce, Claim::kForceColumns});
  constexpr double kMass = 2, kStiffness = 90, kStart = 0.1;
  constexpr int kSteps = 60;
  for (const uint32_t substeps : {1u, 2u, 3u}) {
    const auto world = Weightless(GetParam());
    Do(*world, SetStepper{{.substeps = substeps}});
    const EntityId ball = Add(*world, Ball({kStart, 0, 5}, 0.2, kMass));
    const double h = world->scene().world.stepper.step_size;
    const double angle = 2 * std::asin(std::sqrt(kStiffness / kMass) * h / 2);
    for (int i = 1; i <= kSteps; ++i) {
      const Vector3 pull(-kStiffness * PositionOf(*world, ball).x(), 0, 0);
      if (i % 2 == 0) {
        Do(*world, ApplyForce{.id = ball, .force = pull, .sampled = true});
      } else {
        Do(*world, ApplyForceColumns{.ids = {ball}, .forces = {pull}, .torques = {}, .sampled = true});
      }
      Steps(*world, 1);
      ASSERT_NEAR(PositionOf(*world, ball).x(), kStart * std::cos(i * angle), kRounding) << i << ", " << substeps;
    }
    // Nothing more is known of the course: what it was at last stays what it was.
    const Vector3 left = VelocityOf(*world, ball);
    Steps(*world, 3);
    EXPECT_LE((VelocityOf(*world, ball) - left).norm(), kRounded) << substeps;
  }
}

TEST_P(Forces, SampledOnesTurnABodyAsVerletDoes) {
  Proves({Claim::kForce});
  constexpr double kStiffness = 2, kStart = 0.1;  // N*m/rad, rad
  constexpr int kSteps = 60;
  const auto world = Weightless(GetParam());
  EntityDesc ball = Ball({0, 0, 5}, 0.5, 1);
  ball.pose.orientation = Quaternion(Eigen::AngleAxisd(kStart, Vector3::UnitZ()));
  const EntityId id = Add(*world, ball);
  const double moment = 0.4 * 0.25, h = world->scene().world.stepper.step_size;
  const double angle = 2 * std::asin(std::sqrt(kStiffness / moment) * h / 2);
  const auto turned = [&] { return 2 * std::asin(world->state().pose(EntityRow{id.index()}).orientation.z()); };
  for (int i = 1; i <= kSteps; ++i) {
    Do(*world, ApplyForce{.id = id, .torque = {0, 0, -kStiffness * turned()}, .sampled = true});
    Steps(*world, 1);
    ASSERT_NEAR(turned(), kStart * std::cos(i * angle), kRounding) << i;
  }
}

TEST_P(Forces, SampledOnesForgetTheLastStepOfWhatIsPutElsewhere) {
  Proves({Claim::kForce});
  const auto world = Weightless(GetParam());
  const EntityId ball = Add(*world, Ball({0, 0, 5}, 0.2, 1));
  Do(*world, ApplyForce{.id = ball, .force = {600, 0, 0}, .sampled = true});
  Steps(*world, 1);
  Do(*world, SetVelocity{.id = ball, .linear = Vector3(1, 0, 0)});
  Do(*world, ApplyForce{.id = ball, .force = {60, 0, 0}, .sampled = true});
  Steps(*world, 1);
  EXPECT_NEAR(VelocityOf(*world, ball).x(), 2, kRounded);
}

TEST_P(Forces, SampledOnesAreOfOneStep) {
  Proves({Claim::kForce});
  const auto world = Weightless(GetParam());
  const EntityId ball = Add(*world, Ball({0, 0, 5}, 0.2, 1));
  const Command two = ApplyForce{.id = ball, .force = {1, 0, 0}, .steps = 2, .sampled = true};
  const std::optional<Refusal> refusal = RefusalOf(world->Apply({&two, 1}).status());
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->reason, Reason::kInvalidValue);
  EXPECT_EQ(refusal->field, "commands[0].apply_force.steps");
}

TEST_P(Forces, AnImpulseChangesMomentumAtOnce) {
  Proves({Claim::kImpulse});
  const auto world = Weightless(GetParam());
  const EntityId ball = Add(*world, Ball({0, 0, 0}, 0.5, 2));

  Do(*world, ApplyImpulse{.id = ball, .linear = {0, 6, 0}, .point = Vector3(0.5, 0, 0)});

  EXPECT_NEAR(VelocityOf(*world, ball).y(), 3, kRounding);
  EXPECT_NEAR(SpinOf(*world, ball).z(), 0.5 * 6 / (0.4 * 2 * 0.25), kRounding);
}

TEST_P(Forces, DampingDecaysExponentially) {
  Proves({Claim::kDamping});
  const auto world = Weightless(GetParam());
  EntityDesc ball = Ball({0, 0, 0});
  ball.rigid_body->linear_velocity = {1, 0, 0};
  ball.rigid_body->angular_velocity = {0, 0, 1};
  ball.rigid_body->linear_damping = 0.5;
  ball.rigid_body->angular_damping = 2;
  const EntityId id = Add(*world, ball);

  Steps(*world, 60);

  EXPECT_NEAR(VelocityOf(*world, id).x(), std::exp(-0.5), kRounding);
  EXPECT_NEAR(SpinOf(*world, id).z(), std::exp(-2.0), kRounding);
}

TEST_P(Forces, GravityActsByItsScale) {
  Proves({Claim::kGravityScale});
  const auto world = testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -10}, .ground_plane = false});
  EntityDesc light = Ball({0, 0, 0}), floating = Ball({3, 0, 0}), rising = Ball({6, 0, 0});
  light.rigid_body->gravity_scale = 0.25;
  floating.rigid_body->gravity_scale = 0;
  rising.rigid_body->gravity_scale = -1;
  const EntityId a = Add(*world, light), b = Add(*world, floating), c = Add(*world, rising);

  Steps(*world, 60);

  EXPECT_NEAR(VelocityOf(*world, a).z(), -2.5, kRounding);
  EXPECT_EQ(VelocityOf(*world, b).z(), 0);
  EXPECT_NEAR(VelocityOf(*world, c).z(), 10, kRounding);
}

TEST_P(Forces, AnUpdateOfTheScaleOfGravityWakesASleeper) {
  Proves({Claim::kGravityScale, Claim::kSleeping});
  const auto world = MakeWorld();
  const EntityId crate = Add(*world, Crate({0, 0, 0.5}));
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, crate));

  UpdateEntity update{.id = crate, .entity = Crate({0, 0, 0.5})};
  update.entity.rigid_body->gravity_scale = -1;
  update.fields.Add(EntityField::kGravityScale);
  Do(*world, update);
  Steps(*world, 60);

  EXPECT_NEAR(VelocityOf(*world, crate).z(), 9.81, kRounding);
}

TEST_P(Forces, NothingIsFasterThanItsSpeedMax) {
  Proves({Claim::kSpeedMax});
  const auto world = testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -10}, .ground_plane = false});
  EntityDesc slow = Crate({0, 0, 0});
  slow.rigid_body->linear_speed_max = 2;
  slow.rigid_body->angular_speed_max = 3;
  slow.rigid_body->linear_velocity = {0, 50, 0};
  slow.rigid_body->angular_velocity = {0, 0, 40};
  const EntityId id = Add(*world, slow);

  for (int i = 0; i < 120; ++i) {
    Steps(*world, 1);
    ASSERT_LE(VelocityOf(*world, id).norm(), 2 + kRounding);
    ASSERT_LE(SpinOf(*world, id).norm(), 3 + kRounding);
  }

  // All of its speed has turned downwards by then: the part aside is v / cosh(g t / v), which leaves u^2 / (2 v).
  EXPECT_NEAR(VelocityOf(*world, id).z(), -2, 2 * std::pow(2 / std::cosh(10 * 2.0 / 2), 2) / (2 * 2));
  EXPECT_NEAR(SpinOf(*world, id).z(), 3, kRounding);
}

TEST_P(Forces, SpeedsMaxHoldAgainstAKick) {
  Proves({Claim::kSpeedMax});
  const auto world = Weightless(GetParam());
  EntityDesc ball = Ball({0, 0, 0});
  ball.rigid_body->linear_speed_max = 1;
  const EntityId id = Add(*world, ball);

  Do(*world, ApplyImpulse{.id = id, .linear = {30, 40, 0}});
  Steps(*world, 60);

  // The direction of the kick stays, and no step was made at more than the limit.
  EXPECT_TRUE(VelocityOf(*world, id).isApprox(Vector3(0.6, 0.8, 0), kRounding));
  EXPECT_TRUE(PositionOf(*world, id).isApprox(Vector3(0.6, 0.8, 0), kRounding));
}

TEST_P(Forces, NothingTurnsFasterThanItsSpeedMaxInAnyStep) {
  Proves({Claim::kSpeedMax});
  // Each limit by itself, whatever the other one is.
  for (const std::optional<double>& linear : {std::optional<double>(), std::optional<double>(50.0)}) {
    const auto world = Weightless(GetParam());
    EntityDesc ball = Ball({0, 0, 0}, 0.5, 2);
    ball.rigid_body->linear_speed_max = linear;
    ball.rigid_body->angular_speed_max = 1;
    const EntityId id = Add(*world, ball);
    Do(*world, ApplyImpulse{.id = id, .angular = {0, 0, 5}});
    Steps(*world, 30);
    EXPECT_NEAR(SpinOf(*world, id).z(), 1, kRounding);
    const Quaternion turned(Eigen::AngleAxisd(0.5, Vector3::UnitZ()));
    EXPECT_LE(FromColumn(world->state().orientations.col(id.index())).angularDistance(turned), kRounding);
  }
}

TEST_P(Forces, TheNetForceOfARestingCrateIsNothingAndOfAFallingOneItsWeight) {
  Proves({Claim::kNetForce});
  const auto world = MakeWorld();
  EntityDesc rests = Crate({0, 0, 0.5}, 0.5, 3);
  rests.rigid_body->auto_disable.enabled = false;
  const EntityId resting = Add(*world, rests), falling = Add(*world, Crate({5, 0, 50}, 0.5, 3));

  Steps(*world, 60);

  EXPECT_NEAR(world->state().net_forces.col(resting.index()).norm(), 0, kSwept * 3 * 9.81);
  EXPECT_NEAR(world->state().net_forces(2, falling.index()), -3 * 9.81, 3 * 9.81 * kRounding);
}

TEST_P(Forces, TheNetForceOnWhoIsOutOfTheWorldIsNothing) {
  Proves({Claim::kNetForce, Claim::kBounds});
  const auto world = Weightless(GetParam());
  const EntityId id = Add(*world, Rocket(2));
  Do(*world, ApplyForce{.id = id, .force = {0, 3, 0}, .torque = {0, 0, 1}, .steps = 100});
  Steps(*world, 1);
  ASSERT_NEAR(world->state().net_forces(1, id.index()), 3, kRounding);
  ASSERT_GT(world->state().net_torques(2, id.index()), 0);

  Steps(*world, 1);

  ASSERT_EQ(Of<EntityFaulted>(world->TakeEvents()).size(), 1u);
  EXPECT_EQ(world->state().net_forces.col(id.index()), Vector3(0, 0, 0));
  EXPECT_EQ(world->state().net_torques.col(id.index()), Vector3(0, 0, 0));
}

// However much it takes in a step: of a thousandth, and so much that no number is as small as what is left.
TEST_P(Forces, TheNetTorqueOnWhatFliesIsWhatDampingTakes) {
  Proves({Claim::kNetForce, Claim::kDamping});
  for (const double step : {0.01, 0.25}) {
    for (const double damping : {0.1, 10.0, 2900.0, 1e4}) {
      const auto world = Weightless(GetParam());
      EntityDesc ball = Ball({0, 0, 5}, 0.5, 2);
      ball.rigid_body->auto_disable.enabled = false;
      ball.rigid_body->angular_damping = damping;
      ball.rigid_body->angular_velocity = {0, 3, 0};
      const EntityId id = Add(*world, ball);
      double left = 0.2 * 3;
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(world->Step(step).ok());
        const double torque = left * std::expm1(-damping * step) / step;
        EXPECT_NEAR(world->state().net_torques(1, id.index()), torque, kRounding * 0.6 / step) << damping << ", " << i;
        left *= std::exp(-damping * step);
      }
    }
  }
}

TEST_P(Forces, AnImpulseThatTurnsABodyTooFastTakesItOutAndNobodyElse) {
  Proves({Claim::kImpulse, Claim::kBounds, Claim::kFaultEvents});
  for (const double impulse : {1e5, 1e9, 1e12}) {
    for (const double height : {0.0, 5.0}) {
      const auto world = MakeWorld();
      EntityDesc plate = Body(Box{{0.5, 0.2, 0.05}}, {0, 0, 1.05 + height});
      const EntityId lower = Add(*world, Crate({0, 0, 0.5})), upper = Add(*world, plate);
      Steps(*world, 10);
      world->TakeEvents();

      Do(*world, ApplyImpulse{.id = upper, .angular = impulse * Vector3(0.5, 0.7, 0.3)});
      Steps(*world, 10);

      const auto faulted = Of<EntityFaulted>(world->TakeEvents());
      ASSERT_EQ(faulted.size(), 1u) << impulse << " at " << height;
      EXPECT_EQ(faulted[0].id, upper);
      EXPECT_TRUE(PositionOf(*world, upper).allFinite());
      EXPECT_LE((PositionOf(*world, lower) - Vector3(0, 0, 0.5)).norm(), 2 * kTouch) << impulse << " at " << height;
    }
  }
}

TEST_P(Forces, ASpinningBodyKeepsItsAngularMomentum) {
  Proves({Claim::kFreeRotation});
  const auto world = Weightless(GetParam());
  EntityDesc plate = Body(Box{{0.5, 0.2, 0.05}}, {0, 0, 0});
  plate.rigid_body->angular_velocity = {0.01, 5, 0.01};
  const EntityId id = Add(*world, plate);
  const auto momentum = [&] {
    const Matrix3 rotation = FromColumn(world->state().orientations.col(id.index())).toRotationMatrix();
    const Matrix3& tensor = world->scene().entities[id.index()]->mass.tensor;
    return Vector3(rotation * tensor * rotation.transpose() * SpinOf(*world, id));
  };
  const Vector3 before = momentum();

  Steps(*world, 600);

  EXPECT_LE((momentum() - before).norm(), kRounding * before.norm()) << "however it tumbles";
}

// Where a body of that tensor (of its axes, which are those of the world at first) is after `time` seconds of constant
// torque, by the classical method of Runge and Kutta in steps of a millisecond, of which each turns it by little.
Quaternion TurnedByTorque(const Matrix3& tensor, const Vector3& spin, const Vector3& torque, double time) {
  constexpr double kFine = 1e-3;
  const Vector3 momentum = tensor * spin;
  const auto rate = [&](const Eigen::Vector4d& at, double now) -> Eigen::Vector4d {
    const Quaternion turn = Quaternion(at).normalized();
    const Vector3 own = turn.conjugate() * (momentum + now * torque);
    const Vector3 half = turn * (tensor.inverse() * own) / 2;
    return (Quaternion(0, half.x(), half.y(), half.z()) * turn).coeffs();
  };
  Eigen::Vector4d at = Quaternion::Identity().coeffs();
  for (double now = 0; now < time - kFine / 2; now += kFine) {
    const Eigen::Vector4d first = rate(at, now), second = rate(at + kFine / 2 * first, now + kFine / 2);
    const Eigen::Vector4d third = rate(at + kFine / 2 * second, now + kFine / 2);
    at += kFine / 6 * (first + 2 * second + 2 * third + rate(at + kFine * third, now + kFine));
  }
  return Quaternion(at).normalized();
}

TEST_P(Forces, ATorqueThatTurnsTheAxisOfTheSpinTurnsTheBodyToFourthOrder) {
  Proves({Claim::kForce});
  const Vector3 spin(0.5, 3, -1), torque(1, -0.4, 0.6);
  EntityDesc ball = Ball({0, 0, 5}, 0.5, 2), brick = Ball({0, 0, 5}, 0.5, 2);
  brick.rigid_body->inertia.tensor = Vector3(0.1, 0.25, 0.3).asDiagonal();
  for (EntityDesc desc : std::array{ball, brick}) {
    const auto world = Weightless(GetParam());
    desc.rigid_body->angular_velocity = spin;
    const EntityId id = Add(*world, desc);
    const Matrix3 tensor = desc.rigid_body->inertia.tensor.value_or(0.2 * Matrix3::Identity());
    Do(*world, ApplyForce{.id = id, .torque = torque, .steps = 120});
    double fastest = 0;
    for (int i = 0; i < 120; ++i) {
      Steps(*world, 1);
      fastest = std::max(fastest, SpinOf(*world, id).norm());
    }
    // Of that order in each step.
    const double error = 120 * std::pow(fastest * kStep, 5) / 120;
    const Quaternion now = world->state().pose(EntityRow{id.index()}).orientation;
    EXPECT_LE(now.angularDistance(TurnedByTorque(tensor, spin, torque, 2)), error);
  }
}

}  // namespace
}  // namespace genphys::testing

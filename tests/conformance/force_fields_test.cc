// Forces that act on until they are deleted: the layer's own, so the same on every engine.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine_test.h"
#include "genphys/limits.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ForceFields);

// Of numbers up to thirty.
constexpr double kRounding = 30 * kRounded;
constexpr double kStep = 1.0 / 60;
// m: these tests wait thirty times the decay of a damped swing of less than a metre, or longer: e^-30 of it is left.
constexpr double kAtRest = 1e-12;

std::unique_ptr<World> Weightless(const std::string& engine) {
  return MakeWorld(WorldDesc{.engine = engine, .gravity = {0, 0, 0}, .ground_plane = false});
}

ForceFieldId AddField(World& world, const ForceField& field) { return Do(world, CreateForceField{field}).packed(); }

EntityDesc Awake(EntityDesc desc) {
  desc.rigid_body->auto_disable.enabled = false;
  return desc;
}

TEST_P(ForceFields, AUniformOnePushesEverythingFromThenOn) {
  Proves({Claim::kUniformField});
  const auto world = Weightless(GetParam());
  const EntityId light = Add(*world, Ball({0, 0, 0}, 0.5, 1)), heavy = Add(*world, Ball({3, 0, 0}, 0.5, 4));
  const ForceFieldId field = AddField(*world, {UniformField{.force = {0, 2, 0}, .acceleration = {0, 0, 1}}});

  Steps(*world, 60);
  EXPECT_TRUE(VelocityOf(*world, light).isApprox(Vector3(0, 2, 1), kRounding));
  EXPECT_TRUE(VelocityOf(*world, heavy).isApprox(Vector3(0, 0.5, 1), kRounding));

  Do(*world, DeleteForceField{field});
  Steps(*world, 60);
  EXPECT_TRUE(VelocityOf(*world, light).isApprox(Vector3(0, 2, 1), kRounding));
}

TEST_P(ForceFields, ActOnlyOnWhomTheyName) {
  Proves({Claim::kUniformField});
  const auto world = Weightless(GetParam());
  const EntityId named = Add(*world, Ball({0, 0, 0})), other = Add(*world, Ball({3, 0, 0}));
  AddField(*world, {.kind = UniformField{.force = {0, 0, 1}}, .entities = {named}});

  Steps(*world, 60);
  EXPECT_NEAR(VelocityOf(*world, named).z(), 1, kRounding);
  EXPECT_EQ(VelocityOf(*world, other), Vector3(0, 0, 0));

  Do(*world, DeleteEntity{named});
  Steps(*world, 60);
  EXPECT_EQ(VelocityOf(*world, other), Vector3(0, 0, 0)) << "a field that lost all it acted on acts on nobody";
  EXPECT_TRUE(world->scene().force_fields.empty());
}

TEST_P(ForceFields, ActOnTheOneThatMovesAmongManyWhoSleep) {
  Proves({Claim::kDragField, Claim::kSleeping});
  const auto world = MakeWorld();
  ForceField field{.kind = DragField{.linear = 1}};
  for (int i = 0; i < 5; ++i) field.entities.push_back(Add(*world, Crate({3.0 * i, 0, 0.5})));
  const std::vector<EntityId> crates = field.entities;
  const auto fly = [&](double y) {
    EntityDesc ball = Awake(Ball({0, y, 5}));
    ball.rigid_body->gravity_scale = 0;
    ball.rigid_body->linear_velocity = {0, 0, 2};
    return Add(*world, ball);
  };
  const EntityId named = fly(5), other = fly(-5);
  field.entities.push_back(named);
  Steps(*world, 120);
  AddField(*world, field);
  Steps(*world, 120);
  for (const EntityId id : crates) ASSERT_TRUE(Asleep(*world, id));

  Steps(*world, 60);

  EXPECT_NEAR(VelocityOf(*world, named).z(), 2 * std::exp(-3.0), kRounding);
  EXPECT_EQ(VelocityOf(*world, other).z(), 2);
  for (const EntityId id : crates) EXPECT_TRUE(Asleep(*world, id));
}

TEST_P(ForceFields, ActOnlyInsideTheirRegion) {
  Proves({Claim::kUniformField});
  const auto world = Weightless(GetParam());
  const EntityId inside = Add(*world, Ball({0, 0, 0})), outside = Add(*world, Ball({3, 0, 0}));
  AddField(*world, {.kind = UniformField{.force = {0, 0, 1}}, .region = Region{{1, -1, -1}, {-1, 1, 0.5}}});

  Steps(*world, 120);

  // It leaves through the upper side at v = sqrt(2 a z), one step later at most.
  EXPECT_NEAR(VelocityOf(*world, inside).z(), std::sqrt(2 * 0.5), kStep);
  EXPECT_EQ(VelocityOf(*world, outside), Vector3(0, 0, 0));
}

TEST_P(ForceFields, LinearDragIsExactWhateverItsCoefficient) {
  Proves({Claim::kDragField});
  for (const double drag : {0.5, 500.0}) {
    const auto world = Weightless(GetParam());
    EntityDesc ball = Ball({0, 0, 0}, 0.5, 2);
    ball.rigid_body->linear_velocity = {3, 0, 0};
    const EntityId id = Add(*world, ball);
    AddField(*world, {DragField{.linear = drag}});

    Steps(*world, 60);

    EXPECT_NEAR(VelocityOf(*world, id).x(), 3 * std::exp(-drag / 2), kRounding);
  }
}

TEST_P(ForceFields, QuadraticDragIsExact) {
  Proves({Claim::kDragField});
  const auto world = Weightless(GetParam());
  EntityDesc ball = Ball({0, 0, 0}, 0.5, 2);
  ball.rigid_body->linear_velocity = {0, 30, 0};
  const EntityId id = Add(*world, ball);
  AddField(*world, {DragField{.quadratic = 0.4}});

  Steps(*world, 60);

  EXPECT_NEAR(VelocityOf(*world, id).y(), 30 / (1 + 0.4 * 30 / 2), kRounding);
}

TEST_P(ForceFields, WhatSlidesAgainstDragStopsWhereTheClosedFormSays) {
  Proves({Claim::kDragField, Claim::kKineticFriction});
  constexpr double kMass = 2, kSpeed = 3, kGravity = 9.81, kFriction = 0.3, kBend = 0.5;  // 1/m, drag over mass
  const auto error = [&](double step_size) {
    WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}, .stepper = {.step_size = step_size}};
    desc.default_material.friction = kFriction;
    const auto world = testing::MakeWorld(desc);
    EntityDesc crate = Crate({0, 0, 0.5}, 0.5, kMass);
    crate.rigid_body->linear_velocity = {kSpeed, 0, 0};
    const EntityId id = Add(*world, crate);
    AddField(*world, {.kind = DragField{.quadratic = kBend * kMass}, .entities = {id}});
    Steps(*world, static_cast<int>(std::lround(1.5 / step_size)));
    // v dv/dx = -mu g - b v^2.
    const double stop = std::log1p(kBend * kSpeed * kSpeed / (kFriction * kGravity)) / (2 * kBend);
    return std::abs(PositionOf(*world, id).x() - stop);
  };
  const double coarse = error(kStep), fine = error(kStep / 4);
  EXPECT_LT(coarse, 1e-4);
  EXPECT_GT(coarse, 12 * fine) << "at a quarter of the step a sixteenth of the error";
}

TEST_P(ForceFields, WindCarriesThingsAlong) {
  Proves({Claim::kDragField});
  const auto world = Weightless(GetParam());
  const EntityId id = Add(*world, Ball({0, 0, 0}, 0.5, 2));
  AddField(*world, {DragField{.linear = 3, .medium_velocity = {4, 0, 0}}});

  Steps(*world, 60);

  EXPECT_NEAR(VelocityOf(*world, id).x(), 4 * (1 - std::exp(-1.5)), kRounding);
}

TEST_P(ForceFields, AFallAgainstDragEndsAtItsTerminalVelocity) {
  Proves({Claim::kDragField});
  const auto world =
      testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -9.81}, .ground_plane = false});
  const EntityId id = Add(*world, Ball({0, 0, 0}, 0.5, 2));
  AddField(*world, {DragField{.linear = 4}});

  Steps(*world, 600);

  // e^-20 is left of how it began.
  EXPECT_NEAR(VelocityOf(*world, id).z(), -9.81 / (4.0 / 2), 1e-8 * 9.81);
}

TEST_P(ForceFields, AngularDragIsExact) {
  Proves({Claim::kDragField});
  const auto world = Weightless(GetParam());
  EntityDesc ball = Ball({0, 0, 0}, 0.5, 2);
  ball.rigid_body->angular_velocity = {0, 0, 5};
  const EntityId id = Add(*world, ball);
  const double inertia = 0.4 * 2 * 0.25, drag = 0.1;
  AddField(*world, {DragField{.angular = drag}});

  Steps(*world, 60);

  const double exact = 5 * std::exp(-drag / inertia);
  EXPECT_NEAR(SpinOf(*world, id).z(), exact, 1e-12 * exact);
}

// About each principal axis by itself, however hard.
TEST_P(ForceFields, AngularDragStopsWhatIsLightAboutAnAxisTheSooner) {
  Proves({Claim::kDragField, Claim::kBox});
  for (const double drag : {1e-2, 1e6}) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto world = Weightless(GetParam());
      EntityDesc slab = Body(Box{{0.1, 0.3, 0.5}}, {0, 0, 0}, 2);
      slab.rigid_body->angular_velocity = Vector3::Unit(axis);
      const EntityId id = Add(*world, slab);
      AddField(*world, {DragField{.angular = drag}});

      Steps(*world, 60);

      const Vector3 squares = Vector3(0.1, 0.3, 0.5).cwiseAbs2();
      const double inertia = 2.0 / 3 * (squares.sum() - squares[axis]);
      EXPECT_NEAR(SpinOf(*world, id)[axis], std::exp(-drag / inertia), 1e-12) << drag;
    }
  }
}

TEST_P(ForceFields, WhatFallsThroughAnyMediumComesToTheSpeedThatCarriesIt) {
  Proves({Claim::kDragField});
  constexpr double kGravity = 9.81;
  for (const double drag : {1.0, 30.0, 1e3, 1e6}) {
    for (const bool is_quadratic : {false, true}) {
      const auto world =
          testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -kGravity}, .ground_plane = false});
      const EntityId ball = Add(*world, Awake(Ball({0, 0, 0}, 0.1)));
      AddField(*world, {is_quadratic ? DragField{.quadratic = drag} : DragField{.linear = drag}});
      const double wanted = is_quadratic ? std::sqrt(kGravity / drag) : kGravity / drag;

      Steps(*world, 900);
      const double from = PositionOf(*world, ball).z();
      Steps(*world, 60);

      // What goes with the square of speed is taken in turns with pushes, while that is less than a fifth in a substep:
      // off by a tenth of its square. Of what does not, e^-15 is left of how it began.
      const double part = is_quadratic ? 4e-3 : 1e-6;
      EXPECT_NEAR(from - PositionOf(*world, ball).z(), wanted, part * wanted) << drag << ' ' << is_quadratic;
      EXPECT_NEAR(-VelocityOf(*world, ball).z(), wanted, 2 * part * wanted) << drag << ' ' << is_quadratic;
    }
  }
}

TEST_P(ForceFields, ALightBallRisesThroughWaterAsFastAsThatLetsIt) {
  Proves({Claim::kBuoyancyField});
  constexpr double kRadius = 0.15, kMass = 3e-3, kGravity = 9.81, kDrag = 17;
  const auto world =
      testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -kGravity}, .ground_plane = false});
  const EntityId ball = Add(*world, Awake(Ball({0, 0, -5}, kRadius, kMass)));
  AddField(*world, {BuoyancyField{.drag = {.quadratic = kDrag}}});
  const double lift = (1000.0 * 4 / 3 * std::numbers::pi * kRadius * kRadius * kRadius - kMass) * kGravity;

  Steps(*world, 60);

  const double wanted = std::sqrt(lift / kDrag);
  EXPECT_NEAR(VelocityOf(*world, ball).z(), wanted, 1e-6 * wanted);
  EXPECT_NEAR(PositionOf(*world, ball).z(), -5 + wanted, 1e-2 * wanted);
}

TEST_P(ForceFields, APointPullsThingsIntoAnOrbit) {
  Proves({Claim::kPointGravityField});
  constexpr double kRadius = 4, kStrength = 100;
  const double speed = std::sqrt(kStrength / kRadius), omega = speed / kRadius;
  const auto world = Weightless(GetParam());
  EntityDesc moon = Ball({kRadius, 0, 0}, 0.1);
  moon.rigid_body->linear_velocity = {0, speed, 0};
  const EntityId id = Add(*world, moon);
  AddField(*world, {PointGravityField{.strength = kStrength}});

  for (int i = 0; i < 600; ++i) {
    Steps(*world, 1);
    // The symplectic Euler method keeps an orbit within the angle of a step of the true one.
    ASSERT_NEAR(PositionOf(*world, id).norm(), kRadius, 2 * OffCircle(kRadius * omega, SubstepOf(*world), kRadius));
  }
}

TEST_P(ForceFields, AnythingFloatsAsDeepAsItsDensitySays) {
  Proves({Claim::kBuoyancyField});
  const auto world =
      testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -9.81}, .ground_plane = false});
  EntityDesc box = Body(Box{{0.5, 0.5, 0.25}}, {0, 0, 0.2}, 0.3 * 1000 * 0.5);
  const EntityId id = Add(*world, Awake(box));
  AddField(*world, {BuoyancyField{.drag = {.linear = 500, .angular = 100}}});

  Steps(*world, 3600);

  // 0.3 of its height of 0.5 m are below.
  EXPECT_NEAR(PositionOf(*world, id).z(), 0.25 - 0.3 * 0.5, kAtRest);
}

TEST_P(ForceFields, AStoneSinksAndABubbleRises) {
  Proves({Claim::kBuoyancyField});
  const auto world =
      testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -9.81}, .ground_plane = false});
  const double volume = 4.0 / 3 * std::acos(-1.0) * 0.001;
  const EntityId stone = Add(*world, Ball({0, 0, -5}, 0.1, 2500 * volume));
  const EntityId bubble = Add(*world, Ball({1, 0, -5}, 0.1, 500 * volume));
  AddField(*world, {BuoyancyField{}});

  Steps(*world, 30);

  EXPECT_NEAR(VelocityOf(*world, stone).z(), -9.81 * (1 - 1 / 2.5) / 2, kRounding);
  EXPECT_NEAR(VelocityOf(*world, bubble).z(), -9.81 * (1 - 1 / 0.5) / 2, kRounding);
}

TEST_P(ForceFields, AFluidLiftsAtTheMiddleOfWhatIsBelowIt) {
  Proves({Claim::kBuoyancyField});
  constexpr double kOff = 0.1, kMass = 3, kMoment = 0.5, kDensity = 800, kFall = 9.81, kSeconds = 1.0 / 60;
  const auto world = testing::MakeWorld({.engine = GetParam(), .gravity = {0, 0, -kFall}, .ground_plane = false});
  EntityDesc buoy = Ball({0, 0, 0}, 0.5, kMass);
  buoy.rigid_body->inertia.center_of_mass = Vector3(kOff, 0, 0);
  buoy.rigid_body->inertia.tensor = kMoment * Matrix3::Identity();
  const EntityId id = Add(*world, buoy);
  Do(*world, CreateForceField{{.kind = BuoyancyField{.surface_offset = 10, .fluid_density = kDensity}}});
  Steps(*world, 1);
  // All of it is below; its middle lies beside the centre of mass.
  const double lift = kDensity * 4.0 / 3 * M_PI * 0.125 * kFall;
  const double spin = kOff * lift / kMoment * kSeconds;
  // The arm turns within the step, by w h / 2 in all, and is shorter by half the square of that then.
  EXPECT_NEAR(SpinOf(*world, id).y(), spin, 2 * spin * std::pow(spin * kSeconds / 2, 2) / 2);
}

TEST_P(ForceFields, WakeWhomTheyMayMove) {
  Proves({Claim::kUniformField});
  const auto world = MakeWorld();
  const EntityId crate = Add(*world, Crate({0, 0, 0.5}));
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, crate));

  const ForceFieldId field = AddField(*world, {UniformField{.force = {0, 0, 20}}});
  Steps(*world, 30);
  EXPECT_GT(VelocityOf(*world, crate).z(), 1);

  Do(*world, UpdateForceField{field, {UniformField{}}});
  Steps(*world, 300);
  EXPECT_TRUE(Asleep(*world, crate));
}

TEST_P(ForceFields, WakeNobodyOnWhomTheyDoNotAct) {
  Proves({Claim::kUniformField, Claim::kSpringField});
  const auto world = MakeWorld();
  const EntityId named = Add(*world, Crate({0, 0, 0.5})), tied = Add(*world, Crate({10, 0, 0.5}));
  const EntityId here = Add(*world, Crate({20, 0, 0.5})), there = Add(*world, Crate({30, 0, 0.5}));
  const EntityId other = Add(*world, Crate({40, 0, 0.5}));
  const std::vector<EntityId> all{named, tied, here, there, other};
  const auto sleep = [&] {
    Steps(*world, 200);
    for (const EntityId id : all) ASSERT_TRUE(Asleep(*world, id));
  };
  const auto expect_awake = [&](const std::vector<EntityId>& awake) {
    for (const EntityId id : all) EXPECT_EQ(!Asleep(*world, id), std::ranges::count(awake, id) > 0);
    sleep();
  };
  sleep();
  // They act, but move nobody.
  const UniformField push{.force = {1e-9, 0, 0}};
  const auto around = [](double x) { return Region{{x - 1, -1, 0}, {x + 1, 1, 1}}; };
  const ForceFieldId on_named = AddField(*world, {push, {named}});
  expect_awake({named});
  const ForceFieldId in_region = AddField(*world, {push, {}, around(20)});
  expect_awake({here});
  const SpringField spring{.a = tied, .point_in_b = {10, 0, 5}, .rest_length = 4.5, .stiffness = 1};
  const ForceFieldId between = AddField(*world, {spring});
  expect_awake({tied});

  Do(*world, UpdateForceField{on_named, {push, {named, other}}});
  expect_awake({named, other});
  Do(*world, UpdateForceField{in_region, {push, {}, around(30)}});
  expect_awake({here, there});
  Do(*world, UpdateForceField{between, {spring}});
  expect_awake({tied});

  Do(*world, DeleteForceField{on_named});
  expect_awake({named, other});
  Do(*world, DeleteForceField{in_region});
  expect_awake({there});
  Do(*world, DeleteForceField{between});
  expect_awake({tied});
}

TEST_P(ForceFields, WhatASpringTiesSleepsAndWakesTogether) {
  Proves({Claim::kSpringField});
  const auto world = MakeWorld();
  const EntityId a = Add(*world, Crate({0, 0, 0.5})), b = Add(*world, Crate({4, 0, 0.5}));
  AddField(*world, {SpringField{.a = a, .b = b, .rest_length = 4, .stiffness = 10}});
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, a) && Asleep(*world, b));

  Do(*world, ApplyImpulse{.id = a, .linear = {-3, 0, 0}});

  EXPECT_FALSE(Asleep(*world, b));
}

TEST_P(ForceFields, WhoIsLeftOfASpringWakesAndNobodyElse) {
  Proves({Claim::kSpringField});
  const auto world = MakeWorld();
  const EntityId a = Add(*world, Crate({0, 0, 0.5})), b = Add(*world, Crate({4, 0, 0.5}));
  const EntityId other = Add(*world, Crate({9, 0, 0.5}));
  AddField(*world, {SpringField{.a = a, .b = b, .rest_length = 4, .stiffness = 10}});
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, a) && Asleep(*world, b) && Asleep(*world, other));

  Do(*world, DeleteEntity{a});

  EXPECT_FALSE(Asleep(*world, b));
  EXPECT_TRUE(Asleep(*world, other));
}

TEST_P(ForceFields, StayWhenTheEngineChanges) {
  Proves({Claim::kEngineChange});
  const auto world = Weightless(GetParam());
  const EntityId id = Add(*world, Ball({0, 0, 0}));
  AddField(*world, {UniformField{.force = {0, 0, 1}}});
  for (const std::string& engine : {GetParam(), OtherEngine(GetParam()), GetParam()}) {
    Do(*world, SetEngine{engine});
    Steps(*world, 30);
  }

  EXPECT_NEAR(VelocityOf(*world, id).z(), 3 * 0.5, kRounding);
}

TEST_P(ForceFields, AreAtMostAsManyAsAWorldHolds) {
  Proves({Claim::kUniformField});
  const auto world = MakeWorld();
  const std::vector<Command> all(Limits::kForceFieldsMax, CreateForceField{{.kind = UniformField{}}});
  ASSERT_TRUE(world->Apply(all).ok());
  const Command one_more = all[0];
  EXPECT_EQ(RefusalOf(world->Apply({&one_more, 1}).status()).value_or(Refusal{}).reason, Reason::kLimitExceeded);
  Do(*world, DeleteForceField{1});
  Do(*world, one_more);
  EXPECT_EQ(world->scene().force_fields.size(), Limits::kForceFieldsMax);
}

TEST_P(ForceFields, AreRefusedWithTheFieldThatIsWrong) {
  Proves({Claim::kUniformField});
  const auto world = MakeWorld();
  const EntityId ball = Add(*world, Ball({0, 0, 2}));
  const EntityId floor = Add(*world, Block({9, 0, 0}, {1, 1, 1}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto verdict = [&](const Command& command) {
    const uint64_t before = world->StateHash();
    const Status status = world->Apply({&command, 1}).status();
    EXPECT_EQ(world->StateHash(), before);
    const auto refusal = RefusalOf(status);
    return refusal ? std::string(NameOf(refusal->reason)) + " " + refusal->field : std::string("accepted");
  };
  const std::string path = "commands[0].create_force_field.field.";

  EXPECT_EQ(verdict(CreateForceField{{UniformField{.force = {nan, 0, 0}}}}), "NOT_FINITE " + path + "uniform.force.x");
  EXPECT_EQ(verdict(CreateForceField{{DragField{.linear = -1}}}), "OUT_OF_RANGE " + path + "drag.linear");
  EXPECT_EQ(verdict(CreateForceField{{SpringField{.stiffness = 1}}}), "MISSING_FIELD " + path + "spring.entity_a");
  EXPECT_EQ(verdict(CreateForceField{{SpringField{.a = ball, .b = ball}}}),
            "INVALID_VALUE " + path + "spring.entity_b");
  EXPECT_EQ(verdict(CreateForceField{{SpringField{.a = floor}}}), "INVALID_VALUE " + path + "spring.entity_a");
  EXPECT_EQ(verdict(CreateForceField{{PointGravityField{.softening = 0}}}),
            "OUT_OF_RANGE " + path + "point_gravity.softening");
  EXPECT_EQ(verdict(CreateForceField{{BuoyancyField{.surface_normal = {0, 0, 2}}}}),
            "NOT_UNIT_LENGTH " + path + "buoyancy.surface_normal");
  EXPECT_EQ(verdict(CreateForceField{{.kind = UniformField{}, .entities = {floor}}}),
            "INVALID_VALUE " + path + "entity_ids[0]");
  EXPECT_EQ(verdict(CreateForceField{{.kind = UniformField{}, .region = Region{{2e7, 0, 0}, {0, 0, 0}}}}),
            "OUT_OF_RANGE " + path + "region.corner.x");
  EXPECT_EQ(verdict(UpdateForceField{7, {UniformField{}}}), "ENTITY_NOT_FOUND commands[0].update_force_field.field.id");
  EXPECT_EQ(verdict(DeleteForceField{7}), "ENTITY_NOT_FOUND commands[0].delete_force_field.field_id");
  EXPECT_EQ(verdict(DeleteForceField{0}), "MISSING_FIELD commands[0].delete_force_field.field_id");
}

}  // namespace
}  // namespace genphys::testing

// Springs and dampers between entities that act on until they are deleted, on every engine.
#include <cmath>

#include "engine_test.h"
#include "genphys/limits.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(SpringFields, Claim::kSpringField);

constexpr double kRounding = 30 * kRounded;
constexpr double kStep = 1.0 / 60;
// m: these tests wait thirty times the decay of a damped swing of less than a metre, or longer: e^-30 of it is left.
constexpr double kAtRest = 1e-12;

std::unique_ptr<World> Weightless(const std::string& engine) {
  return MakeWorld(WorldDesc{.engine = engine, .gravity = {0, 0, 0}, .ground_plane = false});
}

void AddField(World& world, const ForceField& field) { Do(world, CreateForceField{field}); }

EntityDesc Awake(EntityDesc desc) {
  desc.rigid_body->auto_disable.enabled = false;
  return desc;
}

TEST_P(SpringFields, ASpringSwingsAsItsClosedFormSays) {
  constexpr double kMass = 2, kStiffness = 50, kAmplitude = 0.3;
  const double omega = std::sqrt(kStiffness / kMass);
  const auto world = Weightless(GetParam());
  const double turn = omega * SubstepOf(*world);
  const EntityId ball = Add(*world, Awake(Ball({1 + kAmplitude, 0, 0}, 0.1, kMass)));
  AddField(*world, {SpringField{.a = ball, .rest_length = 1, .stiffness = kStiffness}});

  for (int i = 1; i <= 300; ++i) {
    Steps(*world, 1);
    // Its phase runs off by w t (w h)^2 / 24.
    const double tolerance = 2 * kAmplitude * omega * i * kStep * turn * turn / 24;
    ASSERT_NEAR(PositionOf(*world, ball).x() - 1, kAmplitude * std::cos(omega * i * kStep), tolerance) << i;
  }
}

TEST_P(SpringFields, ADampedSpringSwingsAsItsClosedFormSaysToSecondOrder) {
  constexpr double kMass = 2, kOmega = 4, kPart = 0.3, kAmplitude = 0.4, kSeconds = 1.5;  // of critical damping
  const auto error = [&](double step_size) {
    const auto world = MakeSpace(GetParam(), {.step_size = step_size}, Vector3::Zero());
    const EntityId ball = Add(*world, Awake(Ball({1 + kAmplitude, 0, 0}, 0.1, kMass)));
    AddField(
        *world,
        {SpringField{
            .a = ball, .rest_length = 1, .stiffness = kMass * kOmega * kOmega, .damping = 2 * kPart * kMass * kOmega}});
    Steps(*world, static_cast<int>(std::lround(kSeconds / step_size)));
    const double slower = std::sqrt(1 - kPart * kPart), turned = slower * kOmega * kSeconds;
    const double exact =
        kAmplitude * std::exp(-kPart * kOmega * kSeconds) * (std::cos(turned) + kPart / slower * std::sin(turned));
    return std::abs(PositionOf(*world, ball).x() - 1 - exact);
  };
  const double coarse = error(kStep), fine = error(kStep / 4);
  EXPECT_LT(coarse, 2e-4 * kAmplitude);
  EXPECT_GT(coarse, 12 * fine) << "at a quarter of the step a sixteenth of the error";
}

TEST_P(SpringFields, AHardDamperStopsWhatItHoldsAndTurnsNothingRound) {
  for (const double damping : {1e3, 1e5, 1e8}) {
    const auto world = Weightless(GetParam());
    EntityDesc ball = Awake(Ball({2, 0, 0}, 0.1, 2));
    ball.rigid_body->linear_velocity = {1, 0, 0};
    const EntityId id = Add(*world, ball);
    AddField(*world, {SpringField{.a = id, .rest_length = 2, .stiffness = 1, .damping = damping}});
    for (int step = 1; step <= 10; ++step) {
      Steps(*world, 1);
      // What is left of its way pulls it back ever so slowly.
      ASSERT_GT(VelocityOf(*world, id).x(), -1.0 / damping) << damping << " " << step;
    }
    EXPECT_LT(VelocityOf(*world, id).x(), 1e-3) << damping;
  }
}

TEST_P(SpringFields, ASpringHoldsAWeightWhereItsForceIsTheWeight) {
  const auto world =
      testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -9.81}, .ground_plane = false});
  const EntityId ball = Add(*world, Awake(Ball({0, 0, 3}, 0.1, 2)));
  AddField(*world,
           {SpringField{.a = ball, .point_in_b = {0, 0, 4}, .rest_length = 1, .stiffness = 200, .damping = 20}});

  Steps(*world, 600);

  EXPECT_NEAR(PositionOf(*world, ball).z(), 3 - 2 * 9.81 / 200, kAtRest);
}

TEST_P(SpringFields, AWeightBetweenTwoDampedSpringsHangsWhereTheirForcesSay) {
  const auto world =
      testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = {0, 0, -9.81}, .ground_plane = false});
  const EntityId ball = Add(*world, Awake(Ball({0, 0, 3}, 0.1, 2)));
  AddField(*world,
           {SpringField{.a = ball, .point_in_b = {0, 0, 4}, .rest_length = 1, .stiffness = 200, .damping = 20}});
  AddField(*world,
           {SpringField{.a = ball, .point_in_b = {0, 0, 2}, .rest_length = 1, .stiffness = 300, .damping = 40}});

  Steps(*world, 600);

  EXPECT_NEAR(PositionOf(*world, ball).z(), 3 - 2 * 9.81 / 500, kAtRest);
}

TEST_P(SpringFields, ASpringBetweenTwoKeepsTheirMomentum) {
  const auto world = Weightless(GetParam());
  EntityDesc turned = Crate({2, 0, 0}, 0.3, 3);
  const EntityId a = Add(*world, Awake(Crate({0, 0, 0}))), b = Add(*world, Awake(turned));
  AddField(*world, {SpringField{.a = a,
                                .b = b,
                                .point_in_a = {0.5, 0.5, 0},
                                .point_in_b = {0, -0.3, 0.3},
                                .rest_length = 0.5,
                                .stiffness = 80,
                                .damping = 1}});

  Steps(*world, 200);

  const Vector3 momentum = VelocityOf(*world, a) + 3 * VelocityOf(*world, b);
  EXPECT_LT(momentum.norm(), kRounding);
  EXPECT_GT(SpinOf(*world, a).norm(), 1e-3) << "it pulls beside the centre of mass";
}

TEST_P(SpringFields, TheStiffestSpringStaysFinite) {
  const auto world = Weightless(GetParam());
  const EntityId ball = Add(*world, Awake(Ball({2, 0, 0}, 0.1, 1e-3)));
  AddField(*world, {SpringField{.a = ball, .rest_length = 1, .stiffness = 1e15}});

  Steps(*world, 600);

  // Backward Euler leaves 1 / (1 + (w h)^2) of the stretch of a metre after the first step: less than a rounding.
  EXPECT_NEAR(PositionOf(*world, ball).norm(), 1, kRounded);
}

}  // namespace
}  // namespace genphys::testing

// How far from the truth bodies move: exactly where forces are constant, to second order where they are not.
#include <cmath>
#include <numbers>
#include <random>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Motion, Claim::kEnginesAgree);

constexpr double kGravity = 9.81;
// m, half a second after what held a body is gone: promised.
constexpr double kReleased = 1e-5;

std::unique_ptr<World> WorldOf(const std::string& engine, double step_size) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}};
  desc.stepper.step_size = step_size;
  desc.stepper.substeps = 1;
  desc.default_auto_disable.enabled = false;
  return testing::MakeWorld(desc);
}

TEST_P(Motion, IsExactInFreeFallWhateverTheSteps) {
  std::mt19937 dice(3);
  std::uniform_real_distribution<double> size(1e-3, 0.05);
  const auto world = WorldOf(GetParam(), 1.0 / 60);
  EntityDesc ball = Ball({0, 0, 1000}, 0.1);
  ball.rigid_body->linear_velocity = {3, -2, 5};
  const EntityId id = Add(*world, ball);
  double time = 0;
  for (int i = 0; i < 200; ++i) {
    const double step = size(dice);
    ASSERT_TRUE(world->Step(step).ok());
    time += step;
    const Vector3 fallen(3 * time, -2 * time, 1000 + 5 * time - kGravity * time * time / 2);
    ASSERT_NEAR((PositionOf(*world, id) - fallen).norm(), 0, 1000 * kRounded) << "step " << i;
    ASSERT_NEAR((VelocityOf(*world, id) - Vector3(3, -2, 5 - kGravity * time)).norm(), 0, 100 * kRounded);
  }
}

TEST_P(Motion, OfAThinRodThatTumblesKeepsItsEnergy) {
  Proves({Claim::kFreeRotation});
  for (const double step : {1.0 / 60, 1.0 / 240}) {
    for (const double radius : {1e-3, 1e-2}) {
      const auto world =
          testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false});
      EntityDesc rod = Body(Capsule{radius, 1 - radius}, {0, 0, 0});
      rod.rigid_body->angular_velocity = {0, 20, 2};
      const EntityId id = Add(*world, rod);
      const MassProperties& mass = world->scene().entities[id.index()]->mass;
      const auto spin_in_body = [&]() -> Vector3 {
        return world->state().pose(EntityRow{id.index()}).orientation.conjugate() * SpinOf(*world, id);
      };
      const double energy = spin_in_body().dot(mass.tensor * spin_in_body());
      for (int i = 0; i < 300; ++i) {
        ASSERT_TRUE(world->Step(step).ok());
        // Of so thin a rod what rounding makes of its momentum turns it about its axis.
        ASSERT_NEAR(spin_in_body().z(), 2, 1e-4) << "radius " << radius << ", step " << i;
        ASSERT_NEAR(spin_in_body().dot(mass.tensor * spin_in_body()), energy, 1e-9 * energy);
      }
    }
  }
}

// How a body with the moments `moments` (ascending) turns over that begins with the spin `spin` about the middle axis
// and a little, `beside`, about the last one: in half a period of Jacobi's sine, Landau and Lifshitz, Mechanics, 37.
struct TurningOver {
  TurningOver(const Vector3& moments, double spin, double beside) {
    const double a = moments[0], b = moments[1], c = moments[2];
    const double energy = b * spin * spin + c * beside * beside;
    const double above = c * (c - b) * beside * beside;  // L^2 - 2 E b
    const double wide = above + (b - a) * energy;        // L^2 - 2 E a
    const double rate = std::sqrt((c - b) * wide / (a * b * c));
    double mean = 1, complement = std::sqrt((c - a) * above / ((c - b) * wide));
    while (mean - complement > 1e-15) {
      const double product = mean * complement;
      mean = (mean + complement) / 2;
      complement = std::sqrt(product);
    }
    period = std::numbers::pi / mean / rate;
    const double rounded = kSameEnergy * (1 / a + 1 / b + 1 / c) * b * energy;
    shift = b * rounded / above / rate;
  }

  // See core/src/motion/free_rotation.cc.
  static constexpr double kSameEnergy = 4e-15;
  double period = 0;  // s, from one time to the next
  double shift = 0;   // s, by which a period changes with what the energy may be off by
};

// What steps miss of energy and momentum is nothing beside how much a body has of both, but not beside what parts it
// from one that turns over never.
TEST_P(Motion, TurnsABodyOverAsOftenAsEllipticIntegralsSay) {
  Proves({Claim::kFreeRotation});
  constexpr double kStep = 1.0 / 60, kDuration = 60;
  for (const Vector3& moments :
       {Vector3(2, 3, 4), Vector3(0.08, 0.24, 0.25), Vector3(0.6, 1, 1.3), Vector3(0.1, 1, 1.05)}) {
    for (const double beside : {1e-2, 1e-4}) {
      for (const bool engine_only : {false, true}) {
        constexpr double kSpin = 5;
        const auto world =
            testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false});
        StepperDesc stepper{.step_size = kStep};
        stepper.engine_only = engine_only;
        Do(*world, SetStepper{stepper});
        EntityDesc desc = Ball({0, 0, 0}, 0.1);
        desc.rigid_body->inertia.tensor = moments.asDiagonal();
        desc.rigid_body->angular_velocity = {0, kSpin, beside};
        const EntityId id = Add(*world, desc);
        std::vector<double> times;
        double before = kSpin;
        for (int i = 1; i * kStep < kDuration; ++i) {
          Steps(*world, 1);
          const double now =
              (world->state().pose(EntityRow{id.index()}).orientation.conjugate() * SpinOf(*world, id)).y();
          if (now * before < 0) times.push_back((i + now / (before - now)) * kStep);
          before = now;
        }
        const TurningOver wanted(moments, kSpin, beside);
        const auto name = ::testing::Message() << moments.transpose() << ", beside " << beside;
        ASSERT_EQ(times.size(), static_cast<size_t>(kDuration / wanted.period + 0.5)) << name;
        // Each period is off by what all before it were; the rest is where between two steps it crosses zero.
        double expected = wanted.period / 2, error = 1e-3;
        for (const double time : times) {
          EXPECT_NEAR(time, expected, error) << name;
          error += (expected / wanted.period + 1) * wanted.shift;
          expected += wanted.period;
        }
      }
    }
  }
}

TEST_P(Motion, IsExactUnderAForceThatStartsAndEnds) {
  const double h = 1.0 / 60;
  const auto world = WorldOf(GetParam(), h);
  const EntityId id = Add(*world, Ball({0, 0, 500}, 0.1, 2));
  Steps(*world, 30);
  const Vector3 start = PositionOf(*world, id);
  Do(*world, ApplyForce{.id = id, .force = {8, 0, 0}, .steps = 45});
  Steps(*world, 60);
  // 45 steps at 4 m/s^2, 15 without.
  const double pushed = 45 * h, coasted = 15 * h;
  EXPECT_NEAR(VelocityOf(*world, id).x(), 4 * pushed, 100 * kRounded);
  EXPECT_NEAR(PositionOf(*world, id).x() - start.x(), 2 * pushed * pushed + 4 * pushed * coasted, 1000 * kRounded);
}

TEST_P(Motion, StopsASlideWhereFrictionSaysInEveryDirection) {
  for (const double h : {1.0 / 60, 1.0 / 240}) {
    for (const double heading : {0.0, 0.3, 0.8, 1.9, 4.0}) {
      const auto world = WorldOf(GetParam(), h);
      const double friction = 0.5, speed = 4;
      EntityDesc slab = Body(Box{{0.2, 0.2, 0.05}}, {0, 0, 0.05});
      slab.rigid_body->linear_velocity = {speed * std::cos(heading), speed * std::sin(heading), 0};
      const EntityId id = Add(*world, slab);
      Steps(*world, static_cast<int>(1.5 / h));
      const double wanted = speed * speed / (2 * friction * kGravity), error = StopError(friction * kGravity, h);
      const Vector3 way = PositionOf(*world, id);
      EXPECT_NEAR(std::hypot(way.x(), way.y()), wanted, 2 * error) << "heading " << heading << ", step " << h;
      EXPECT_NEAR(std::atan2(way.y(), way.x()), std::remainder(heading, 2 * std::numbers::pi), 2 * kSwept)
          << "what sweeps leave across the way";
    }
  }
}

TEST_P(Motion, FallsAsFromRestWhenTheSupportIsTaken) {
  const auto world = WorldOf(GetParam(), 1.0 / 60);
  const EntityId table = Add(*world, Block({0, 0, 4.5}, {1, 1, 0.5}));
  const EntityId crate = Add(*world, Crate({0.1, 0.2, 5.5}, 0.5));
  Steps(*world, 60);
  const Vector3 rest = PositionOf(*world, crate);
  Do(*world, DeleteEntity{table});
  Steps(*world, 30);
  EXPECT_NEAR(PositionOf(*world, crate).z(), rest.z() - kGravity / 8, 2 * SweptSpeed(kGravity, 1.0 / 60) / 2)
      << "after half a second";
}

// They still touch each other, but nothing holds them any more.
TEST_P(Motion, OfAPileFallsAsFromRestWhenItsSupportIsTaken) {
  for (const double h : {1.0 / 60, 1.0 / 240}) {
    const auto world = WorldOf(GetParam(), h);
    const EntityId table = Add(*world, Block({0, 0, 4.5}, {3, 3, 0.5}));
    std::vector<EntityId> pile;
    for (const double x : {-1.5, 1.5}) pile.push_back(Add(*world, Crate({x, 0, 5.5}, 0.5)));
    pile.push_back(Add(*world, Body(Box{{2.5, 0.5, 0.25}}, {0, 0, 6.25})));
    pile.push_back(Add(*world, Ball({0, 0, 7}, 0.5)));
    Steps(*world, 60);
    std::vector<Vector3> rest;
    for (const EntityId id : pile) rest.push_back(PositionOf(*world, id));
    Do(*world, DeleteEntity{table});
    Steps(*world, static_cast<int>(std::lround(0.5 / h)));
    for (size_t i = 0; i < pile.size(); ++i) {
      const Vector3 fallen = rest[i] - Vector3(0, 0, kGravity / 8);
      EXPECT_LT((PositionOf(*world, pile[i]) - fallen).norm(), kReleased) << "body " << i;
    }
  }
}

TEST_P(Motion, OfThoseWhomAJointHoldsTogetherFallsAsFromRestWhenTheirSupportIsTaken) {
  const auto world = WorldOf(GetParam(), 1.0 / 60);
  const EntityId table = Add(*world, Block({0, 0, 4.5}, {3, 3, 0.5}));
  const EntityId left = Add(*world, Crate({-0.6, 0, 5.5}, 0.5)), right = Add(*world, Crate({0.6, 0, 5.5}, 0.5));
  JointDesc hinge{.kind = HingeJoint{}};
  hinge.entity_a = {left, {}};
  hinge.entity_b = {right, {}};
  hinge.frame_in_a = Pose{{0.6, 0, 0}, Quaternion::Identity()};
  Do(*world, CreateJoint{hinge});
  Steps(*world, 60);
  const double rest = PositionOf(*world, left).z();
  Do(*world, DeleteEntity{table});
  Steps(*world, 30);
  EXPECT_NEAR(PositionOf(*world, left).z(), rest - kGravity / 8, kReleased);
}

// Soon after a contact began or was disturbed, too.
TEST_P(Motion, IsThatOfAFreeBodyWhenItIsPulledOffWhatItTouches) {
  for (const double h : {1.0 / 60, 1.0 / 240}) {
    for (int steps = 1; steps <= 10; ++steps) {
      for (const bool turns : {false, true}) {
        const auto world = WorldOf(GetParam(), h);
        const EntityId crate = Add(*world, Crate({0, 0, 0.5}, 0.5));
        Steps(*world, steps);
        const Vector3 rest = PositionOf(*world, crate);
        if (turns) {
          Do(*world, SetGravity{{0, 0, 7}});
        } else {
          const double mass = world->scene().entities[crate.index()]->mass.mass;
          Do(*world, ApplyForce{.id = crate, .force = {0, 0, mass * (kGravity + 7)}, .steps = 1'000});
        }
        Steps(*world, static_cast<int>(std::lround(0.5 / h)));
        EXPECT_NEAR(PositionOf(*world, crate).z(), rest.z() + 7.0 / 8, kReleased)
            << steps << " steps, turned: " << turns;
      }
    }
  }
}

TEST_P(Motion, RisesAsFromRestWhenGravityTurns) {
  const auto world = WorldOf(GetParam(), 1.0 / 60);
  const EntityId crate = Add(*world, Crate({0, 0, 0.5}, 0.5));
  Steps(*world, 60);
  const Vector3 rest = PositionOf(*world, crate);
  Do(*world, SetGravity{{0, 0, kGravity}});
  Steps(*world, 30);
  EXPECT_NEAR(PositionOf(*world, crate).z(), rest.z() + kGravity / 8, 2 * SweptSpeed(kGravity, 1.0 / 60) / 2)
      << "after half a second";
}

// Distance from where a rod of 1 m, hinged at its end and let go from the horizontal, has its centre after `time`.
double PendulumError(const std::string& engine, double step_size, double time) {
  const auto world = WorldOf(engine, step_size);
  EntityDesc rod = Body(Box{{0.5, 0.025, 0.025}}, {0.5, 0, 5});
  rod.rigid_body->inertia.tensor = Vector3(1e-3, 1.0 / 12, 1.0 / 12).asDiagonal();
  const EntityId id = Add(*world, rod);
  JointDesc hinge{.kind = HingeJoint{}};
  hinge.entity_b = {id, {}};
  hinge.frame_in_a = Pose{{0, 0, 5}, Quaternion(Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3::UnitX()))};
  Do(*world, CreateJoint{hinge});
  Steps(*world, static_cast<int>(std::lround(time / step_size)));
  // theta'' = -3 g / (2 l) sin theta, by the classical method of Runge and Kutta with steps that leave 1e-12.
  double angle = std::numbers::pi / 2, rate = 0;
  const auto pull = [](double a) { return -1.5 * kGravity * std::sin(a); };
  constexpr int kSteps = 20'000;
  const double h = time / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const double k1 = rate, l1 = pull(angle), k2 = rate + h / 2 * l1, l2 = pull(angle + h / 2 * k1);
    const double k3 = rate + h / 2 * l2, l3 = pull(angle + h / 2 * k2), k4 = rate + h * l3, l4 = pull(angle + h * k3);
    angle += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    rate += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
  }
  return (PositionOf(*world, id) - Vector3(0.5 * std::sin(angle), 0, 5 - 0.5 * std::cos(angle))).norm();
}

TEST_P(Motion, OfAPendulumIsOfSecondOrder) {
  const double coarse = PendulumError(GetParam(), 1.0 / 60, 2), fine = PendulumError(GetParam(), 1.0 / 240, 2);
  // The phase runs off by w t (w h)^2 / 24, and the centre is at most at sqrt(3 g l) / 2.
  const double pulse = std::sqrt(1.5 * kGravity), phase = pulse * 2 * std::pow(pulse / 60, 2) / 24;
  EXPECT_LT(coarse, 2 * phase / pulse * std::sqrt(3 * kGravity) / 2);
  // Four times finer: sixteen times nearer, or more where errors of higher order cancel. The third order is a tenth of
  // it.
  EXPECT_GT(std::log2(coarse / fine) / 2, 1.8);
}

}  // namespace
}  // namespace genphys::testing

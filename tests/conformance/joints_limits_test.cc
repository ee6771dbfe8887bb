// What comes to the limit of a joint between two steps, and is pulled away from it again.
#include <algorithm>
#include <cmath>
#include <vector>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsLimits);

// Of the softness of joints.
constexpr double kPlace = 1e-7;  // m, rad
constexpr double kSpeed = 1e-6;  // m/s, rad/s
constexpr double kSeconds = 1;

EntityDesc Thrown(EntityDesc body, double speed) {
  body.rigid_body->linear_velocity = {0, 0, speed};
  return body;
}

// At `speed` towards a limit `way` ahead, pulled back by `pull` (m/s^2 or rad/s^2) all the time. It does not bounce.
struct Throw {
  double speed, pull, way;

  static Throw Any(Random& random) {
    const double braked = random.Uniform(2, 12), first = random.Uniform(1, 5);
    return {first, braked, random.Uniform(0.1, 0.8) * first * first / (2 * braked)};
  }
  double SpeedThere() const { return std::sqrt(speed * speed - 2 * pull * way); }
  double Reached() const { return (speed - SpeedThere()) / pull; }
  double PlaceAt(double t) const {
    const double since = t - Reached();
    return since < 0 ? speed * t - pull * t * t / 2 : way - pull * since * since / 2;
  }
  double SpeedAt(double t) const { return t < Reached() ? speed - pull * t : -pull * (t - Reached()); }
};

// Calls check(throw, t, place, speed) after each step of ten throws; `sideways` is along x, m/s^2.
template <typename Setup, typename Check>
void ForEachThrow(const std::string& engine, Setup&& setup, Check&& check, double sideways = 0) {
  Random random(7);
  for (const int rate : {30, 60, 240}) {
    for (int i = 0; i < 10; ++i) {
      const Throw thrown = Throw::Any(random);
      const auto world = MakeSpace(engine, {}, {sideways, 0, -thrown.pull});
      const auto look = setup(*world, thrown);
      for (int step = 1; step <= kSeconds * rate; ++step) {
        ASSERT_TRUE(world->Step(1.0 / rate).ok());
        const auto [place, speed] = look();
        check(thrown, static_cast<double>(step) / rate, place, speed);
      }
    }
  }
}

void ExpectThrown(const Throw& thrown, double t, double place, double speed) {
  EXPECT_NEAR(place, thrown.PlaceAt(t), kPlace) << "at " << t << " s";
  EXPECT_NEAR(speed, thrown.SpeedAt(t), kSpeed) << "at " << t << " s";
}

TEST_P(JointsLimits, WhatIsThrownAtTheEndOfASliderFallsFromThere) {
  Proves({Claim::kJointSlider, Claim::kJointLimit});
  const auto setup = [](World& world, const Throw& thrown) {
    const EntityId body = Add(world, Thrown(Crate({0, 0, 0}, 0.1, 2), thrown.speed));
    SliderJoint slider;
    slider.axis.limits.upper = thrown.way;
    Join(world, ToWorld(body, slider));
    return [&world, body] {
      EXPECT_NEAR(VelocityOf(world, body).x(), 0, kSpeed);
      return std::pair(PositionOf(world, body).z(), VelocityOf(world, body).z());
    };
  };
  constexpr double kAcross = 9;  // m/s^2, which the slider bears
  ForEachThrow(GetParam(), setup, ExpectThrown, kAcross);
}

TEST_P(JointsLimits, WhatIsThrownUpOnARopeFallsFromWhereThatIsTaut) {
  Proves({Claim::kJointDistance, Claim::kJointLimit});
  const auto setup = [](World& world, const Throw& thrown) {
    constexpr double kSlack = 10;  // so that it never hangs below
    const EntityId body = Add(world, Thrown(Ball({0, 0, kSlack}, 0.1), thrown.speed));
    DistanceJoint rope;
    rope.axis.limits.upper = kSlack + thrown.way;
    Join(world, ToWorld(body, rope));
    return [&world, body] { return std::pair(PositionOf(world, body).z() - kSlack, VelocityOf(world, body).z()); };
  };
  ForEachThrow(GetParam(), setup, ExpectThrown);
}

TEST_P(JointsLimits, AFlywheelThatATorqueBrakesGoesBackFromTheLimitOfItsHinge) {
  Proves({Claim::kJointHinge, Claim::kJointLimit});
  const auto setup = [](World& world, const Throw& thrown) {
    EntityDesc ball = Ball({0, 0, 0});
    ball.rigid_body->angular_velocity = {0, 0, thrown.speed};
    const EntityId wheel = Add(world, ball);
    HingeJoint hinge;
    hinge.axis.limits.upper = thrown.way;
    const JointId joint = Join(world, ToWorld(wheel, hinge));
    const double moment = 0.4 * ball.rigid_body->inertia.mass.value() * 0.25;
    Do(world, ApplyForce{.id = wheel, .torque = {0, 0, -thrown.pull * moment}, .steps = 1000});
    return [&world, joint] { return std::pair(StateOf(world, joint).positions[5], StateOf(world, joint).rates[5]); };
  };
  ForEachThrow(GetParam(), setup, ExpectThrown);
}

// The same towards the lower limit, but with what pulls it there.
TEST_P(JointsLimits, WhatIsPulledIntoALimitStaysThere) {
  Proves({Claim::kJointSlider, Claim::kJointLimit});
  const auto setup = [](World& world, const Throw& thrown) {
    const EntityId body = Add(world, Thrown(Crate({0, 0, 0}, 0.1, 2), -thrown.speed));
    SliderJoint slider;
    slider.axis.limits.lower = -thrown.way;
    Join(world, ToWorld(body, slider));
    return [&world, body] { return std::pair(PositionOf(world, body).z(), VelocityOf(world, body).z()); };
  };
  ForEachThrow(GetParam(), setup, [](const Throw& thrown, double t, double place, double speed) {
    const double there = std::sqrt(thrown.speed * thrown.speed + 2 * thrown.pull * thrown.way);
    const double reached = (there - thrown.speed) / thrown.pull;
    EXPECT_NEAR(place, t < reached ? -thrown.speed * t - thrown.pull * t * t / 2 : -thrown.way, kPlace) << t;
    EXPECT_NEAR(speed, t < reached ? -thrown.speed - thrown.pull * t : 0, kSpeed) << t;
  });
}

// Nothing holds the rail, which takes part in the blow; a force brakes the cart alone.
TEST_P(JointsLimits, ACartTakesItsRailAlongAndIsPulledAwayFromItsEnd) {
  Proves({Claim::kJointSlider, Claim::kJointLimit});
  constexpr double kRail = 3, kCart = 2;  // kg
  Random random(8);
  for (const int rate : {30, 60, 240}) {
    for (int i = 0; i < 10; ++i) {
      const Throw thrown = Throw::Any(random);
      const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
      const EntityId rail = Add(*world, Crate({0, 0, 0}, 0.1, kRail));
      const EntityId cart = Add(*world, Thrown(Crate({0, 0, 1}, 0.1, kCart), thrown.speed));
      SliderJoint slider;
      slider.axis.limits.upper = thrown.way;
      Join(*world, Between(rail, cart, slider));
      Do(*world, ApplyForce{.id = cart, .force = {0, 0, -thrown.pull * kCart}, .steps = 1000});
      const double together = kCart * thrown.SpeedThere() / (kRail + kCart);
      for (int step = 1; step <= kSeconds * rate; ++step) {
        ASSERT_TRUE(world->Step(1.0 / rate).ok());
        const double t = static_cast<double>(step) / rate, since = std::max(t - thrown.Reached(), 0.0);
        EXPECT_NEAR(PositionOf(*world, rail).z(), together * since, kPlace) << t;
        EXPECT_NEAR(PositionOf(*world, cart).z(), 1 + thrown.PlaceAt(t) + together * since, kPlace) << t;
        EXPECT_NEAR(VelocityOf(*world, rail).z(), since > 0 ? together : 0, kSpeed) << t;
        EXPECT_NEAR(VelocityOf(*world, cart).z(), thrown.SpeedAt(t) + (since > 0 ? together : 0), kSpeed) << t;
      }
    }
  }
}

// What leans on a limit comes to it anew in every other step, and each of these begins from what is shown.
TEST_P(JointsLimits, GiveNoEnergyToWhatLeansOnThem) {
  Proves({Claim::kJointBall, Claim::kJointUniversal, Claim::kJointSlider});
  constexpr int kPairs = 20;
  const AxisLimits narrow{.lower = -0.1, .upper = 0.1};
  const std::vector<JointKind> kinds{BallJoint{.swing_max = 0.3}, BallJoint{.twist = narrow},
                                     UniversalJoint{.about_x = {.limits = narrow}, .about_y = {.limits = narrow}},
                                     SliderJoint{.axis = {.limits = narrow}}};
  for (size_t kind = 0; kind < kinds.size(); ++kind) {
    Random random(5);
    for (int pair = 0; pair < kPairs; ++pair) {
      const auto world = MakeSpace(GetParam(), {.step_size = 1.0 / 240}, Vector3::Zero());
      const Vector3 spin = random.Direction() * random.Uniform(1, 5);
      const auto add = [&](const Vector3& half, double x) {
        EntityDesc box = Body(Box{half}, {x, 0, 0}, random.Uniform(0.3, 3));
        box.rigid_body->angular_velocity = spin;
        box.rigid_body->linear_velocity = spin.cross(box.pose.position);
        if (x < 0 && !std::holds_alternative<SliderJoint>(kinds[kind])) {
          box.rigid_body->angular_velocity += random.Vector(2);
        }
        return Add(*world, box);
      };
      const EntityId a = add({0.3, 0.1, 0.15}, -0.3), b = add({0.3, 0.15, 0.08}, 0.3);
      Join(*world, Between(a, b, kinds[kind], {{0.3, 0, 0}, random.Turn()}));
      Steps(*world, 1);
      double least = KineticEnergyOf(*world), gain = 0;
      for (int step = 0; step < 480; ++step) {
        Steps(*world, 1);
        const double energy = KineticEnergyOf(*world);
        gain = std::max(gain, energy / least - 1);
        least = std::min(least, energy);
      }
      // At most 0.03 of 60 such pairs with each kind.
      EXPECT_LE(gain, 0.1) << "kind " << kind << ", pair " << pair;
    }
  }
}

// Where both z axes point apart there is no twist, and on the other side it may be any.
TEST_P(JointsLimits, OfTwistDoNotFlingWhatSwingsAllAround) {
  Proves({Claim::kJointBall});
  constexpr double kArm = 0.3, kGravity = 9.81;
  Random random(6);
  for (int i = 0; i < 30; ++i) {
    const auto world = MakeSpace(GetParam(), {.step_size = 1.0 / 240});
    EntityDesc rod = Body(Capsule{0.06, 0.2}, {0, 0, 0});
    rod.pose.orientation = random.Turn();
    rod.pose.position = rod.pose.orientation * Vector3(0, 0, kArm);
    rod.rigid_body->angular_velocity = random.Vector(4);
    rod.rigid_body->linear_velocity = rod.rigid_body->angular_velocity.cross(rod.pose.position);
    const EntityId id = Add(*world, rod);
    Join(*world, ToWorld(id, BallJoint{.twist = {.lower = -0.3, .upper = 0.3}}, {{0, 0, 0}, rod.pose.orientation}));
    const auto energy = [&] { return KineticEnergyOf(*world) + kGravity * PositionOf(*world, id).z(); };
    Steps(*world, 1);
    const double before = energy();
    double most = before;
    for (int step = 0; step < 720; ++step) {
      Steps(*world, 1);
      most = std::max(most, energy());
    }
    // At most 0.08 of 60 such rods in 5 s.
    EXPECT_LE(most - before, 0.2 * kGravity * kArm) << "rod " << i;
  }
}

}  // namespace
}  // namespace genphys::testing

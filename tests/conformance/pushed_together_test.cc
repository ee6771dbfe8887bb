// A held force that begins or changes on one of several bodies that touch, or that joints hold, or an impulse on one of
// them, moves them all as if it had acted on them together: from that step on, whenever it comes, and however often.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(PushedTogether, Claim::kForce);

constexpr double kGravity = 9.81;
constexpr double kFriction = 0.3;  // of the floor
constexpr double kGrip = 0.9;      // of boxes on each other
constexpr double kPushed = 0.5;    // s

/// Boxes of 1, 1.5, 2, ... kg, in a row or on each other, of which one is pushed.
struct Group {
  const char* name;
  size_t count;
  bool is_row;
  size_t pushed;
  double floor_speed = 0;  // m/s
  double speed = 0;        // m/s, over that, at which they begin

  double mass() const { return static_cast<double>(count) * (3 + static_cast<double>(count)) / 4; }
  /// N, at which they begin to slide.
  double Threshold() const { return kFriction * mass() * kGravity; }
};

class Pushed {
 public:
  Pushed(const std::string& engine, int rate, const Group& group, double rest) : step_(1.0 / rate) {
    WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = step_}};
    desc.ground_plane = false;
    desc.default_auto_disable.enabled = false;
    world_ = MakeWorld(desc);
    Require(*world_, Feature::kContacts);
    const double own = group.is_row ? kFriction : kGrip;
    EntityDesc floor = Block({0, 0, -1}, {60, 60, 1});
    floor.rigid_body->geometries[0].material.friction = kFriction * kFriction / own;
    if (group.floor_speed != 0) floor.rigid_body->motion_type = MotionType::kKinematic;
    floor.rigid_body->linear_velocity.x() = group.floor_speed;
    Add(*world_, floor);
    for (size_t i = 0; i < group.count; ++i) {
      const auto place = static_cast<double>(i);
      const Vector3 center = group.is_row ? Vector3(0.2 * place, 0, 0.1) : Vector3(0, 0, 0.05 + 0.1 * place);
      const Vector3 half_extents = group.is_row ? Vector3(0.1, 0.1, 0.1) : Vector3(0.3, 0.3, 0.05);
      EntityDesc box = Body(Box{half_extents}, center, 1 + 0.5 * place);
      box.rigid_body->geometries[0].material.friction = own;
      box.rigid_body->linear_velocity.x() = group.floor_speed + group.speed;
      ids_.push_back(Add(*world_, box));
      masses_.push_back(1 + 0.5 * place);
    }
    Steps(*world_, static_cast<int>(std::lround(rest / step_)));
    for (const EntityId id : ids_) from_.push_back(PositionOf(*world_, id).x());
  }

  void Push(size_t which, double force, int steps) {
    Do(*world_, ApplyForce{.id = ids_[which], .force = {force, 0, 0}, .steps = static_cast<uint32_t>(steps)});
    Steps(*world_, steps);
  }
  /// m, by which one of them is at most off the way that all should have gone.
  double ErrorOf(double way) const {
    double most = 0;
    for (size_t i = 0; i < ids_.size(); ++i) {
      most = std::max(most, std::abs(PositionOf(*world_, ids_[i]).x() - from_[i] - way));
    }
    return most;
  }
  void Strike(size_t which, double impulse) { Do(*world_, ApplyImpulse{.id = ids_[which], .linear = {impulse, 0, 0}}); }
  void Go(int steps) { Steps(*world_, steps); }
  /// m, that their centre of mass has gone.
  double MeanWay() const {
    double sum = 0, mass = 0;
    for (size_t i = 0; i < ids_.size(); ++i) {
      sum += masses_[i] * (PositionOf(*world_, ids_[i]).x() - from_[i]);
      mass += masses_[i];
    }
    return sum / mass;
  }
  /// m: what sweeps may leave of each at one solve, and what becomes of that.
  double Allowed() const { return 2 * static_cast<double>(ids_.size()) * kPushed * SweptSpeed(kGravity, step_); }

 private:
  double step_;
  std::unique_ptr<World> world_;
  std::vector<EntityId> ids_;
  std::vector<double> masses_;  // kg
  std::vector<double> from_;    // m
};

TEST_P(PushedTogether, APushThatBeginsOnOneSetsAllOffAtOnce) {
  Proves({Claim::kContacts, Claim::kKineticFriction});
  for (const Group& group : {Group{"one", 1, false, 0}, Group{"two in a row", 2, true, 0},
                             Group{"three in a row", 3, true, 0}, Group{"two, the lower one", 2, false, 0},
                             Group{"two, the upper one", 2, false, 1}, Group{"three, the lowest one", 3, false, 0}}) {
    for (const int rate : {30, 60, 240}) {
      for (const double part : {group.is_row ? 2.5 : 1.15, group.is_row ? 3.3 : 1.5}) {
        Pushed pushed(GetParam(), rate, group, 0.5);
        pushed.Push(group.pushed, part * group.Threshold(), rate / 2);
        const double way = (part - 1) * kFriction * kGravity * kPushed * kPushed / 2;
        // Each for itself, they lost up to 3e-2 of the way at 1/30.
        EXPECT_LE(pushed.ErrorOf(way), pushed.Allowed()) << group.name << ", " << part << ", 1/" << rate << " s";
      }
    }
  }
}

TEST_P(PushedTogether, AForceThatChangesEveryFewStepsIsThatForceAllTheTime) {
  Proves({Claim::kContacts, Claim::kKineticFriction});
  for (const Group& group :
       {Group{"one", 1, false, 0}, Group{"two, the lower one", 2, false, 0}, Group{"two, the upper one", 2, false, 1},
        Group{"one on what moves", 1, false, 0, 1.0}, Group{"two on what moves, the upper one", 2, false, 1, 1.0}}) {
    for (const int rate : {30, 60, 240}) {
      for (int every = 1; every <= 9; ++every) {
        Random random(static_cast<uint64_t>(every));
        Pushed pushed(GetParam(), rate, group, 0.1);
        double speed = group.floor_speed, way = 0;
        for (int left = rate / 2; left > 0; left -= every) {
          const int steps = std::min(every, left);
          const double part = random.Uniform(1.1, 2.5), time = static_cast<double>(steps) / rate;
          pushed.Push(group.pushed, part * group.Threshold(), steps);
          const double acceleration = (part - 1) * kFriction * kGravity;
          way += speed * time + acceleration * time * time / 2;
          speed += acceleration * time;
        }
        // Each for itself, two went by up to 4e-2 m less, however short the steps were.
        EXPECT_LE(pushed.ErrorOf(way), pushed.Allowed()) << group.name << ", every " << every << ", 1/" << rate << " s";
      }
    }
  }
}

constexpr double kTrembles = 1.0 / 60;  // s, a step

// How fast (m/s) anybody in a stack of ten goes while it is disturbed for five seconds: disturb(world, id, step,
// random) is called before each step, with one in the middle.
template <typename Disturb>
double FastestInStack(const std::string& engine, Disturb&& disturb) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = kTrembles}};
  desc.default_material.friction = 0.5;
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  std::vector<EntityId> stack;
  for (int i = 0; i < 10; ++i) stack.push_back(Add(*world, Body(Box{{0.1, 0.1, 0.1}}, {0, 0, 0.1 + 0.2 * i}, 1)));
  Steps(*world, 60);
  Random random(3);
  double fastest = 0;
  for (int step = 0; step < 300; ++step) {
    disturb(*world, stack[5], step, random);
    Steps(*world, 1);
    for (const EntityId id : stack) fastest = std::max(fastest, VelocityOf(*world, id).norm());
  }
  return fastest;
}

Vector3 AnyUpTo(double most, Random& random) {
  const auto part = [&] { return random.Uniform(-most, most); };
  return {part(), part(), part()};
}

// Of what is not pushed hard enough to move nothing but the force itself is to be seen.
TEST_P(PushedTogether, AForceThatTremblesShakesNoStack) {
  Proves({Claim::kContacts, Claim::kStaticFriction});
  constexpr double kForce = 1e-2;  // N
  for (const int every : {1, 2, 5}) {
    const auto push = [&](World& world, EntityId id, int step, Random& random) {
      if (step % every != 0) return;
      Do(world, ApplyForce{.id = id, .force = AnyUpTo(kForce, random), .steps = static_cast<uint32_t>(every)});
    };
    EXPECT_LE(FastestInStack(GetParam(), push), 2 * std::sqrt(3) * kForce * kTrembles)
        << "every " << every;  // each for itself: 4e-3
  }
}

// Whoever of them slips on the others, the floor brakes all.
TEST_P(PushedTogether, ImpulsesOnOneAreThoseOnAll) {
  Proves({Claim::kContacts, Claim::kKineticFriction});
  constexpr double kRest = 0.1, kWhole = 0.4, kSpeed = 3;
  for (const Group& group :
       {Group{"two, the lower one", 2, false, 0, 0, kSpeed}, Group{"two, the upper one", 2, false, 1, 0, kSpeed},
        Group{"three, the middle one", 3, false, 1, 0, kSpeed}}) {
    for (const int rate : {30, 60, 240}) {
      for (const int every : {1, 2, 5, 100}) {
        Pushed pushed(GetParam(), rate, group, kRest);
        double speed = kSpeed - kFriction * kGravity * kRest, way = 0;
        for (int left = static_cast<int>(std::lround(kWhole * rate)); left > 0; left -= every) {
          const int steps = std::min(every, left);
          const double impulse = std::min(0.03 * every, 1.0), time = static_cast<double>(steps) / rate;
          pushed.Strike(group.pushed, impulse);
          pushed.Go(steps);
          speed += impulse / group.mass();
          way += speed * time - kFriction * kGravity * time * time / 2;
          speed -= kFriction * kGravity * time;
        }
        // Each for itself, up to 4e-2.
        EXPECT_NEAR(pushed.MeanWay(), way, pushed.Allowed()) << group.name << ", every " << every << ", 1/" << rate;
      }
    }
  }
}

TEST_P(PushedTogether, ImpulsesThatTrembleShakeNoStack) {
  Proves({Claim::kContacts, Claim::kStaticFriction});
  constexpr double kImpulse = 1e-4;  // N*s
  const auto strike = [&](World& world, EntityId id, int, Random& random) {
    Do(world, ApplyImpulse{.id = id, .linear = AnyUpTo(kImpulse, random)});
  };
  EXPECT_LE(FastestInStack(GetParam(), strike), 2 * std::sqrt(3) * kImpulse);  // each for itself: 1e-2
}

/// m: where the last of three rods that hang on each other is 0.5 s after it began to be pushed.
Vector3 EndOfChain(const std::string& engine, int rate) {
  const auto world = MakeSpace(engine, {.step_size = 1.0 / rate});
  EntityId last;
  for (int i = 0; i < 3; ++i) {
    EntityDesc rod = Body(Box{{0.3, 0.03, 0.03}}, {0.3 + 0.6 * i, 0, 0}, 1 + 0.5 * i);
    rod.rigid_body->geometries[0].collides_with_bits = 0;
    const EntityId id = Add(*world, rod);
    Join(*world, i == 0 ? ToWorld(id, BallJoint{}) : Between(last, id, BallJoint{}, Pose{.position = {0.3, 0, 0}}));
    last = id;
  }
  Steps(*world, rate / 3);
  Do(*world, ApplyForce{.id = last, .force = {0, 0, 10}, .steps = 10'000});
  Steps(*world, rate / 2);
  return PositionOf(*world, last);
}

TEST_P(PushedTogether, APushOnOneOfAChainIsOfSecondOrder) {
  Proves({Claim::kJointBall});
  const Vector3 end = EndOfChain(GetParam(), 3000);
  EXPECT_LE((EndOfChain(GetParam(), 60) - end).norm(), 2e-3);
  EXPECT_LE((EndOfChain(GetParam(), 240) - end).norm(), 2e-3 / 14);  // of first order: 2e-3
}

}  // namespace
}  // namespace genphys::testing

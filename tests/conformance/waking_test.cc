// A sleeper is awake before anything is stopped at it, and nobody is woken by what passes.
#include <algorithm>
#include <ctime>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Waking, Claim::kSleeping, Claim::kContacts);

constexpr double kSide = 1;  // m, of a crate
// Each is wide enough for nobody to touch, and narrow enough for points to be there.
constexpr double kGaps[] = {1.5e-4, 5e-4, 1e-3, 1.9e-3};

/// Frictionless crates in a row along x, each so far (m) behind the one before it, all asleep.
struct Row {
  Row(const std::string& engine, const std::vector<double>& gaps, Quality quality = Quality::kBalanced) {
    WorldDesc desc{.engine = engine, .gravity = {0, 0, -9.81}, .stepper = {.quality = quality}};
    desc.default_material = {.friction = 0, .restitution = 0};
    world = MakeWorld(desc);
    double x = 0;
    crates.push_back(Add(*world, Crate({x, 0, 0.5})));
    for (const double gap : gaps) crates.push_back(Add(*world, Crate({x += kSide + gap, 0, 0.5})));
  }

  void Sleep() const {
    Steps(*world, 120);
    for (const EntityId id : crates) ASSERT_TRUE(Asleep(*world, id));
  }

  double Momentum() const {
    double sum = 0;
    for (const EntityId id : crates) sum += VelocityOf(*world, id).x();
    return sum;
  }

  std::unique_ptr<World> world;
  std::vector<EntityId> crates;  // of 1 kg
};

// The part of a momentum that may be lost: of what is solved by sweeps something is left, 0.7 % at most when nobody
// sleeps.
constexpr double kLost = 0.01;
// The same where several are met one after the other. Rows that never slept are off by up to 16 % then.
constexpr double kLostByMany = 0.25;

TEST_P(Waking, WhatIsPushedOnDoesNotStopAtASleeperAsAtAWall) {
  Require(*MakeWorld(), Feature::kContacts);
  for (const Quality quality : {Quality::kFast, Quality::kBalanced, Quality::kAccurate}) {
    for (const double speed : {1.0, 20.0}) {
      for (const double gap : kGaps) {
        for (const std::vector<double>& gaps : {std::vector{0.0, gap}, {0.0, 0.0, 0.0, gap}, {0.0, gap, gap, gap}}) {
          const Row row(GetParam(), gaps, quality);
          row.Sleep();
          Do(*row.world, SetVelocity{.id = row.crates.front(), .linear = Vector3(speed, 0, 0)});
          Steps(*row.world, 10);
          const double lost = gaps.size() == 2 ? kLost : kLostByMany;
          EXPECT_NEAR(row.Momentum(), speed, lost * speed) << gap << " m behind, of " << gaps.size();
        }
      }
    }
  }
}

TEST_P(Waking, WhatAForceMovesOnDoesNotStopAtASleeperAsAtAWall) {
  Require(*MakeWorld(), Feature::kContacts);
  for (const double gap : kGaps) {
    for (const size_t pushed : {0, 1}) {
      for (const bool sampled : {false, true}) {
        const Row row(GetParam(), {0, gap});
        row.Sleep();
        Do(*row.world, ApplyForce{.id = row.crates[pushed], .force = {600, 0, 0}, .steps = 1, .sampled = sampled});
        Steps(*row.world, 10);
        EXPECT_NEAR(row.Momentum(), 10, kLost * 10) << (sampled ? "sampled, " : "") << gap << " m behind";
      }
    }
  }
}

TEST_P(Waking, WhatAJointTakesAlongDoesNotStopAtASleeperAsAtAWall) {
  Proves({Claim::kJointFixed});
  Require(*MakeWorld(), Feature::kJointFixed);
  constexpr double kApart = 0.5;
  for (const double gap : kGaps) {
    const Row row(GetParam(), {kApart, gap});
    JointDesc joint;
    joint.kind = FixedJoint{};
    joint.entity_a.id = row.crates[0];
    joint.entity_b.id = row.crates[1];
    Do(*row.world, CreateJoint{joint});
    row.Sleep();
    Do(*row.world, SetVelocity{.id = row.crates[0], .linear = Vector3(5, 0, 0)});
    Steps(*row.world, 10);
    EXPECT_NEAR(row.Momentum(), 5, kLost * 5) << gap << " m behind";
  }
}

// Neighbours that only stand beside it take nothing from the floor.
TEST_P(Waking, WhoIsHitFromAboveAmongNeighboursStaysOnTheFloor) {
  Require(*MakeWorld(), Feature::kContacts);
  constexpr double kSpeed = 6, kDrop = 0.5;  // m/s and m
  for (const size_t neighbours : {1, 2}) {
    // It lands in one substep or another.
    for (const double more : {0.0, 0.02, 0.04, 0.06, 0.08}) {
      const Row row(GetParam(), std::vector<double>(neighbours, 0.0));
      row.Sleep();
      EntityDesc falling = Crate({0.2, 0.1, kSide + 0.3 + kDrop + more}, 0.3);
      falling.rigid_body->linear_velocity = {0, 0, -kSpeed};
      Add(*row.world, falling);
      for (int i = 0; i < 10; ++i) {
        Steps(*row.world, 1);
        for (const EntityId id : row.crates) {
          EXPECT_LE(VelocityOf(*row.world, id).norm(), kLost * kSpeed) << neighbours << " beside it, in step " << i;
          EXPECT_LE(SpinOf(*row.world, id).norm(), kLost * kSpeed / kSide) << neighbours << " beside it, in step " << i;
        }
      }
      EXPECT_FALSE(Asleep(*row.world, row.crates.front()));
    }
  }
}

TEST_P(Waking, WhoIsPassedSleepsOn) {
  Require(*MakeWorld(), Feature::kContacts);
  for (const double gap : kGaps) {
    // Alone and as two that touch, at one speed: they give each other nothing.
    for (const int count : {1, 2}) {
      WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -9.81}};
      desc.default_material = {.friction = 0, .restitution = 0};
      const auto world = testing::MakeWorld(desc);
      const EntityId sleeper = Add(*world, Crate({0, 0, 0.5}));
      Steps(*world, 120);
      ASSERT_TRUE(Asleep(*world, sleeper));
      for (int i = 0; i < count; ++i) {
        EntityDesc passing = Crate({-3 - kSide * i, kSide + gap, 0.5});
        passing.rigid_body->linear_velocity = {20, 0, 0};
        Add(*world, passing);
      }
      for (int i = 0; i < 20; ++i) {
        Steps(*world, 1);
        EXPECT_TRUE(Asleep(*world, sleeper)) << count << " at " << gap << " m";
      }
    }
  }
}

TEST_P(Waking, WhoIsStoodBesideSleepsOn) {
  Require(*MakeWorld(), Feature::kContacts);
  for (const double gap : kGaps) {
    const auto world = MakeWorld();
    const EntityId sleeper = Add(*world, Crate({0, 0, 0.5}));
    EntityDesc awake = Crate({kSide + gap, 0, 0.5});
    awake.rigid_body->auto_disable.enabled = false;
    for (int i = 0; i < 3; ++i, awake.pose.position.z() += kSide) Add(*world, awake);
    Steps(*world, 200);
    EXPECT_TRUE(Asleep(*world, sleeper)) << gap << " m";
  }
}

/// A ball that sleeps on a spring or on a rod, 1 m below something at this height (m).
struct Hanging {
  static constexpr double kHeight = 5;

  Hanging(const std::string& engine, EntityDesc holder, bool is_joint) : world(MakeWorld(engine)) {
    holder.pose.position = {0, 0, kHeight};
    held_by = Add(*world, holder);
    ball = Add(*world, Ball({0, 0, kHeight - 1}, 0.2));
    if (is_joint) {
      JointDesc joint;
      joint.kind = BallJoint{};
      joint.entity_a.id = held_by;
      joint.entity_b.id = ball;
      joint.frame_in_a = Pose{};
      joint.frame_in_b = Pose{.position = {0, 0, 1}};
      Do(*world, CreateJoint{joint});
    } else {
      const SpringField spring{.a = held_by, .b = ball, .rest_length = 1 - 9.81 / 1e3, .stiffness = 1e3, .damping = 60};
      Do(*world, CreateForceField{{.kind = spring}});
    }
    Steps(*world, 300);
    EXPECT_TRUE(Asleep(*world, ball));
  }

  std::unique_ptr<World> world;
  EntityId held_by;
  EntityId ball;
};

EntityDesc Carrier(const Vector3& velocity) {
  EntityDesc carrier = Crate({0, 0, Hanging::kHeight}, 0.1);
  carrier.rigid_body->motion_type = MotionType::kKinematic;
  carrier.rigid_body->linear_velocity = velocity;
  return carrier;
}

// Nothing holds it, so that a blow is found in time at it as at one that is awake: at what is taken for held it was
// left overlapping, from which ODE then drove the two apart with up to 8 % of the speed that they had met with.
TEST_P(Waking, WhoFloatsIsHitInItsSleepAsIfItWereAwake) {
  for (double speed = 0.3; speed < 30; speed *= 1.2) {
    WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false};
    desc.default_material = {.friction = 0, .restitution = 0};
    const auto world = testing::MakeWorld(desc);
    Require(*world, Feature::kContacts);
    const EntityId sleeper = Add(*world, Ball({0, 0, 0}, 0.4));
    Steps(*world, 60);
    ASSERT_TRUE(Asleep(*world, sleeper));

    EntityDesc moving = Ball({-1 - 0.7, 0, 0}, 0.3);
    moving.rigid_body->linear_velocity = {speed, 0, 0};
    const EntityId mover = Add(*world, moving);
    Steps(*world, static_cast<int>(60 / speed) + 3);
    ASSERT_FALSE(Asleep(*world, sleeper));
    EXPECT_NEAR(VelocityOf(*world, sleeper).x(), speed / 2, 1e-9 * speed) << speed;
    EXPECT_NEAR(VelocityOf(*world, mover).x(), speed / 2, 1e-9 * speed) << speed;
  }
}

// Gravity and a field that balance each other are owed for half a substep of when it fell asleep.
TEST_P(Waking, WhoFloatsIsWhereItSleptAfterStepsBecameShorter) {
  Proves({Claim::kUniformField});
  for (const double size : {1.0 / 480, 1.0 / 30}) {
    WorldDesc desc{.engine = GetParam(), .ground_plane = false};
    // What flies alone would not come to the engine.
    desc.stepper = {.step_size = 1.0 / 120, .substeps = 1, .engine_only = true};
    const auto world = testing::MakeWorld(desc);
    const Vector3 lift = -world->scene().world.gravity;
    Do(*world, CreateForceField{ForceField{.kind = UniformField{.acceleration = lift}}});
    const EntityId floats = Add(*world, Ball({0, 0, 0}));
    EntityDesc other = Ball({5, 0, 0});
    other.rigid_body->auto_disable.enabled = false;
    Add(*world, other);
    Steps(*world, 120);
    ASSERT_TRUE(Asleep(*world, floats));
    ASSERT_TRUE(world->Step(size).ok());
    Do(*world, ApplyForce{.id = floats});
    ASSERT_FALSE(Asleep(*world, floats));
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(world->Step(size).ok());
    EXPECT_LE(PositionOf(*world, floats).norm(), kRounded) << size;
  }
}

TEST_P(Waking, WhoHangsOnAPlaceWakesWhenItIsPutElsewhere) {
  Proves({Claim::kSpringField});
  Require(*MakeWorld(), Feature::kJointBall);
  for (const bool is_joint : {false, true}) {
    for (const bool is_update : {false, true}) {
      const Hanging hanging(GetParam(), EntityDesc(), is_joint);
      EntityDesc put;
      put.pose.position = {3, 0, Hanging::kHeight};
      if (is_update) {
        Do(*hanging.world, UpdateEntity{hanging.held_by, put, {static_cast<uint32_t>(EntityField::kPose)}});
      } else {
        Do(*hanging.world, SetPose{.id = hanging.held_by, .position = put.pose.position});
      }
      EXPECT_FALSE(Asleep(*hanging.world, hanging.ball)) << (is_joint ? "on a joint" : "on a spring");
    }
  }
}

TEST_P(Waking, WhoHangsOnWhatIsMadeAnotherWakes) {
  Proves({Claim::kSpringField, Claim::kLiveChange});
  Require(*MakeWorld(), Feature::kJointBall);
  constexpr uint32_t kBody = static_cast<uint32_t>(EntityField::kRigidBody);
  for (const bool is_joint : {false, true}) {
    for (const EntityDesc& before : {EntityDesc(), Carrier({0, 0, 0})}) {
      const Hanging hanging(GetParam(), before, is_joint);
      Do(*hanging.world, UpdateEntity{hanging.held_by, Carrier({1, 0, 0}), {kBody}});
      EXPECT_FALSE(Asleep(*hanging.world, hanging.ball))
          << (is_joint ? "on a joint" : "on a spring") << (before.rigid_body ? "" : ", from nothing");
    }
  }
}

// Of this thread, s.
double ProcessorTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// `row` * `row` crates that touch nobody else, all asleep.
struct Field {
  Field(const std::string& engine, int row) : world(testing::MakeWorld(engine)) {
    for (int i = 0; i < row * row; ++i) crates.push_back(Add(*world, Crate({2.0 * (i % row), 2.0 * (i / row), 0.5})));
    for (int i = 0; i < 240 && !AllSleep(); ++i) Steps(*world, 1);
  }
  bool AllSleep() const {
    return std::ranges::all_of(crates, [&](EntityId id) { return Asleep(*world, id); });
  }
  // Drops a ball onto a crate, to the step before they meet.
  void DropOnto(EntityId crate) const {
    EntityDesc ball = Ball(PositionOf(*world, crate) + Vector3(0, 0, 1.1), 0.3);
    ball.rigid_body->linear_velocity = {0, 0, -6};
    Add(*world, ball);
    Steps(*world, 2);
  }

  std::unique_ptr<World> world;
  std::vector<EntityId> crates;
};

// Processor time of the step in which the first of so many is hit, s: the least of some worlds.
double FirstHitTime(const std::string& engine, int row) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const Field field(engine, row);
    if (!field.AllSleep()) ADD_FAILURE() << "they do not sleep";
    field.DropOnto(field.crates.front());
    if (!field.AllSleep()) ADD_FAILURE() << "it was hit too early";
    const double before = ProcessorTime();
    Steps(*field.world, 1);
    least = std::min(least, ProcessorTime() - before);
    EXPECT_FALSE(Asleep(*field.world, field.crates.front()));
  }
  return least;
}

// All of them fell asleep in one step, which had all of them to move. What is to be done once for each of them then was
// once left to the first hit, and that took 20 times as long as one among few.
TEST_P(Waking, TheFirstHitAmongManyTakesAboutAsLongAsAmongFew) {
  Require(*MakeWorld(), Feature::kContacts);
  const double few = FirstHitTime(GetParam(), 4), many = FirstHitTime(GetParam(), 40);
  EXPECT_LT(many, 5 * few);
}

// Whom a blow put elsewhere is looked for in between.
TEST_P(Waking, TheTimeThatImpactsTakeIsToldAsTheirs) {
  Require(*MakeWorld(), Feature::kContacts);
  const Field field(GetParam(), 4);
  std::map<std::string, uint64_t> spent;
  for (const EntityId crate : field.crates) {
    field.DropOnto(crate);
    field.world->set_record_stats(true);
    Steps(*field.world, 1);
    for (const StepStats::Stage& stage : field.world->stats().stages)
      spent[std::string(stage.name)] += stage.nanoseconds;
    field.world->set_record_stats(false);
  }
  EXPECT_GT(spent["impacts"], spent["collide"]);
}

}  // namespace
}  // namespace genphys::testing

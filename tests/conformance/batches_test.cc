// Commands in one batch do what the same commands do one by one, whomever they wake, cut off or take away.
#include <algorithm>
#include <chrono>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Batches, Claim::kSleeping, Claim::kForce);

// A world of things that hold each other, most of them asleep.
class Yard {
 public:
  explicit Yard(const std::string& engine) : world_(MakeWorld(WithoutEvents(engine))) {
    for (int tower = 0; tower < 3; ++tower) {
      for (int i = 0; i < 4; ++i) ids_.push_back(Add(*world_, Crate({3.0 * tower, 0, 0.5 + i})));
    }
    for (int i = 0; i < 5; ++i) {
      ids_.push_back(Add(*world_, Crate({2.0 * i, 6, 0.25}, 0.25)));
      if (i > 0)
        Join(*world_,
             Between(ids_[ids_.size() - 2], ids_.back(), BallJoint{}, FrameAlong(Vector3::UnitZ(), {1, 0, 0})));
    }
    for (int i = 0; i < 4; ++i) ids_.push_back(Add(*world_, Crate({3.0 * i, -6, 0.5})));
    for (const auto& [a, b] : {std::pair(4, 3), std::pair(2, 1)}) {
      const SpringField spring{*(ids_.end() - a), *(ids_.end() - b), Vector3::Zero(), Vector3::Zero(), 3, 10, 5};
      Do(*world_, CreateForceField{.field = {spring}});
    }
    Do(*world_, CreateForceField{.field = {DragField{.linear = 0.1}, {ids_[0], ids_[5]}}});
    EntityDesc plate = Crate({20, 0, 0.5});
    plate.rigid_body->motion_type = MotionType::kKinematic;
    ids_.push_back(Add(*world_, plate));
    Steps(*world_, 240);
  }

  World& world() { return *world_; }

  // Commands that are valid in this order. An entity that goes is named by none of them after that.
  std::vector<Command> Commands(Random& random, size_t count) {
    std::vector<Command> commands;
    while (commands.size() < count) Write(random, commands);
    return commands;
  }

  size_t asleep() const {
    const auto& asleep = world_->state().asleep;
    return static_cast<size_t>(std::count(asleep.begin(), asleep.end(), uint8_t{1}));
  }

 private:
  static WorldDesc WithoutEvents(const std::string& engine) {
    // Whoever wakes and is taken away in one batch is told to have woken only if these are two batches.
    return {.engine = engine,
            .gravity = {0, 0, -9.81},
            .recorded_events = {.contacts = false, .sleeping = false, .changes = false}};
  }

  void Write(Random& random, std::vector<Command>& commands) {
    if (ids_.size() < 4) return commands.push_back(SetGravity{{0, 0, -9.81}});
    const size_t place = random.Below(ids_.size() - 1);  // the last is not dynamic
    const EntityId id = ids_[place];
    switch (random.Below(8)) {
      case 0:
        commands.push_back(DeleteEntity{id});
        ids_.erase(ids_.begin() + static_cast<std::ptrdiff_t>(place));
        return;
      case 1:
        return commands.push_back(CreateEntity{Crate({random.Uniform(-5, 5), -20, 3})});
      case 2:
        return commands.push_back(
            ApplyForce{.id = id, .force = random.Vector(5), .steps = 5, .replace = random.Chance(0.5)});
      case 3:
        return commands.push_back(ApplyImpulse{.id = id, .linear = random.Vector(0.1)});
      case 4:
        return commands.push_back(SetVelocity{.id = id, .linear = random.Vector(0.5)});
      case 5:
        return commands.push_back(SetPose{.id = id, .position = Vector3(random.Uniform(-5, 5), 12, 4)});
      case 6:
        return commands.push_back(SetPose{.id = ids_.back(), .position = Vector3(20, random.Uniform(-1, 1), 0.5)});
      default: {
        EntityDesc now = *world_->Describe(id);
        now.rigid_body->geometries[0].shape = Box{Vector3::Constant(random.Uniform(0.2, 0.5))};
        return commands.push_back(UpdateEntity{id, now, {static_cast<uint32_t>(EntityField::kGeometries)}});
      }
    }
  }

  std::unique_ptr<World> world_;
  std::vector<EntityId> ids_;
};

TEST_P(Batches, DoWhatTheirCommandsDoOneByOne) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Yard batch(GetParam()), singly(GetParam());
    ASSERT_GT(batch.asleep(), 10u);
    Random random(seed), again(seed);
    const std::vector<Command> commands = batch.Commands(random, 1 + seed % 12);
    for (const Command& command : singly.Commands(again, commands.size())) Do(singly.world(), command);
    ASSERT_TRUE(batch.world().Apply(commands).ok());
    EXPECT_EQ(batch.world().state().asleep, singly.world().state().asleep);
    EXPECT_EQ(batch.world().StateHash(), singly.world().StateHash());
    Steps(batch.world(), 60);
    Steps(singly.world(), 60);
    EXPECT_EQ(batch.world().StateHash(), singly.world().StateHash());
  }
}

TEST_P(Batches, ForcesBeforeAReplacementInTheSameBatchAreNone) {
  const auto world = testing::MakeWorld({.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false});
  const EntityId a = Add(*world, Ball({0, 0, 0})), b = Add(*world, Ball({5, 0, 0}));
  const std::vector<Command> commands{
      ApplyForce{.id = a, .force = {60, 0, 0}}, ApplyForce{.id = b, .force = {0, 0, 60}},
      ApplyForce{.id = a, .force = {0, 60, 0}, .replace = true}, ApplyForce{.id = a, .force = {0, 60, 0}}};
  ASSERT_TRUE(world->Apply(commands).ok());
  Steps(*world, 2);
  EXPECT_NEAR((VelocityOf(*world, a) - Vector3(0, 2, 0)).norm(), 0, kRounded);
  EXPECT_NEAR((VelocityOf(*world, b) - Vector3(0, 0, 1)).norm(), 0, kRounded);
}

TEST_P(Batches, WhatRestedOnThoseThatGoFallsHoweverManyGo) {
  const auto world = MakeWorld();
  std::vector<EntityId> tower;
  for (int i = 0; i < 5; ++i) tower.push_back(Add(*world, Crate({0, 0, 0.5 + i})));
  const EntityId bystander = Add(*world, Crate({5, 0, 0.5}));
  Steps(*world, 240);
  ASSERT_TRUE(Asleep(*world, tower[4]) && Asleep(*world, bystander));
  world->TakeEvents();
  const std::vector<Command> commands{DeleteEntity{tower[1]}, DeleteEntity{tower[0]}, DeleteEntity{tower[2]}};
  ASSERT_TRUE(world->Apply(commands).ok());
  EXPECT_FALSE(Asleep(*world, tower[3]));
  EXPECT_FALSE(Asleep(*world, tower[4])) << "it touches none of them";
  EXPECT_TRUE(Asleep(*world, bystander));
  const auto ended = Of<ContactEnded>(world->TakeEvents());
  EXPECT_EQ(ended.size(), 4u) << "with the floor and each other, once each";
  Steps(*world, 120);
  EXPECT_NEAR(PositionOf(*world, tower[3]).z(), 0.5, kTouch);
  EXPECT_NEAR(PositionOf(*world, tower[4]).z(), 1.5, 2 * kTouch);
}

TEST_P(Batches, AFieldThatIsToldOtherEntitiesOutlivesThoseItHad) {
  Proves({Claim::kUniformField});
  const auto world = testing::MakeWorld({.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false});
  const EntityId gone = Add(*world, Ball({0, 0, 0})), stays = Add(*world, Ball({5, 0, 0}));
  ForceField field{UniformField{{0, 0, 60}}, {gone}};
  const EntityId created = Do(*world, CreateForceField{.field = field});
  const ForceFieldId id = created.packed();
  field.entities = {stays};
  const std::vector<Command> commands{DeleteEntity{gone}, UpdateForceField{id, field}};
  ASSERT_TRUE(world->Apply(commands).ok());
  Steps(*world, 1);
  EXPECT_NEAR(VelocityOf(*world, stays).z(), 1, kRounded);
  Do(*world, DeleteEntity{stays});
  const Command late = UpdateForceField{id, {UniformField{{0, 0, 1}}, {}}};
  EXPECT_FALSE(world->Apply({&late, 1}).ok()) << "with the last of its entities it has gone too";
}

// Still ones, each of many spheres, `apart` (m) from each other.
std::vector<Command> Stones(size_t count, double apart) {
  constexpr uint32_t kSpheres = 64;
  EntityDesc stone;
  stone.rigid_body = RigidBody{.motion_type = MotionType::kStatic};
  for (uint32_t i = 0; i < kSpheres; ++i) {
    stone.rigid_body->geometries.push_back(Geometry{.shape = Sphere{0.5}});
  }
  std::vector<Command> commands;
  for (size_t i = 0; i < count; ++i) {
    stone.pose.position = {100 + apart * static_cast<double>(i), 0, 5};
    commands.push_back(CreateEntity{stone});
  }
  return commands;
}

TEST_P(Batches, WakeWhomTheyAreInHoweverManyRestThere) {
  const auto world = MakeWorld();
  std::vector<EntityId> crates;
  for (int i = 0; i < 40; ++i) crates.push_back(Add(*world, Crate({3.0 * i, 50, 0.5})));
  Steps(*world, 240);
  std::vector<Command> commands = Stones(10, 0);
  EntityDesc block = Block({0, 0, 0}, {0.2, 0.2, 0.2});
  block.rigid_body->motion_type = MotionType::kStatic;
  for (size_t i = 0; i < crates.size(); ++i) {
    ASSERT_TRUE(Asleep(*world, crates[i]));
    block.pose.position = PositionOf(*world, crates[i]) + Vector3(0, 0, 0.5);
    if (i % 2 == 0) commands.push_back(CreateEntity{block});
    if (i % 3 == 0) commands.push_back(CreateEntity{block});
  }

  ASSERT_TRUE(world->Apply(commands).ok());

  for (size_t i = 0; i < crates.size(); ++i) EXPECT_EQ(Asleep(*world, crates[i]), i % 2 != 0 && i % 3 != 0) << i;
}

TEST_P(Batches, PutManyIntoOnePlaceInAboutTheTimeThatManyPlacesTake) {
  const auto time_of = [&](double apart) {
    const auto world = MakeWorld();
    Add(*world, Crate({0, 0, 0.5}));
    Steps(*world, 240);
    const std::vector<Command> commands = Stones(400, apart);
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_TRUE(world->Apply(commands).ok());
    return std::chrono::steady_clock::now() - begin;
  };
  const auto usual = time_of(3);
  EXPECT_LT(time_of(0), 8 * usual);
}

TEST_P(Batches, MakeOnlyTheLastOfSeveralEnginesInARow) {
  const auto world = MakeWorld(), twin = MakeWorld();
  std::vector<Command> commands;
  for (int i = 0; i < 2000; ++i) commands.push_back(CreateEntity{Ball({1.5 * (i % 50), 1.5 * (i / 50), 0.5})});
  for (World* each : {world.get(), twin.get()}) {
    ASSERT_TRUE(each->Apply(commands).ok());
    Steps(*each, 2);
  }
  const auto time_of = [](World& of, const std::vector<Command>& batch) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_TRUE(of.Apply(batch).ok());
    return std::chrono::steady_clock::now() - begin;
  };
  const auto once = time_of(*twin, {SetEngine{"none"}, SetGravity{{0, 0, -9}}, SetEngine{GetParam()}});
  commands.assign(1, SetGravity{{0, 0, -9}});
  for (int i = 0; i < 400; ++i) commands.push_back(SetEngine{i % 2 == 0 ? "none" : GetParam()});

  EXPECT_LT(time_of(*world, commands), 50 * once);

  EXPECT_EQ(world->StateHash(), twin->StateHash());
  for (World* each : {world.get(), twin.get()}) Steps(*each, 3);
  EXPECT_EQ(world->StateHash(), twin->StateHash());
}

}  // namespace
}  // namespace genphys::testing

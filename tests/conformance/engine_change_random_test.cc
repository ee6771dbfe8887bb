// Whatever is in a world, a change of its engine loses nothing of it.
#include <cmath>

#include "conformance/engine_test.h"
#include "core/src/model/state_hash.h"
#include "support/joints.h"
#include "support/random_scene.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(EngineChangeOfRandomScenes, Claim::kEngineChange);

constexpr uint64_t kScenes = 200;
// Of speeds of some ten.
constexpr double kRounding = 10 * kRounded;

// All that a client can ask for: description, columns and what the layer remembers, whatever the engine.
struct Everything {
  std::string scene, columns, layer;
  bool operator==(const Everything&) const = default;
};

Everything EverythingOf(const World& world) {
  Everything all;
  Scene scene = world.scene();
  scene.world.engine.clear();
  Serialize(scene, all.scene);
  Serialize(world.state(), all.columns);
  Serialize(world.layer_state(), all.layer);
  return all;
}

std::vector<EntityDesc> DescriptionsOf(const World& world) {
  std::vector<EntityDesc> descriptions;
  for (const std::optional<SceneEntity>& entity : world.scene().entities) {
    if (!entity) continue;
    const Result<EntityDesc> desc = world.Describe(entity->id);
    EXPECT_TRUE(desc.ok()) << desc.status();
    if (desc.ok()) descriptions.push_back(*desc);
  }
  return descriptions;
}

void ExpectSame(const std::vector<EntityDesc>& before, const std::vector<EntityDesc>& after) {
  ASSERT_EQ(before.size(), after.size());
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].display_name, after[i].display_name);
    EXPECT_EQ(before[i].pose, after[i].pose);
    EXPECT_EQ(before[i].visual, after[i].visual);
    ASSERT_EQ(before[i].rigid_body.has_value(), after[i].rigid_body.has_value());
    if (!before[i].rigid_body) continue;
    EXPECT_EQ(before[i].rigid_body->motion_type, after[i].rigid_body->motion_type);
    EXPECT_EQ(before[i].rigid_body->geometries, after[i].rigid_body->geometries);
    EXPECT_EQ(before[i].rigid_body->inertia.mass, after[i].rigid_body->inertia.mass);
    EXPECT_EQ(before[i].rigid_body->linear_velocity, after[i].rigid_body->linear_velocity);
    EXPECT_EQ(before[i].rigid_body->angular_velocity, after[i].rigid_body->angular_velocity);
  }
}

void Change(World& world, const std::string& engine) {
  const std::vector<EntityDesc> descriptions = DescriptionsOf(world);
  const Everything before = EverythingOf(world);
  Do(world, SetEngine{engine});
  EXPECT_EQ(world.scene().world.engine, engine);
  EXPECT_TRUE(EverythingOf(world) == before);
  ExpectSame(descriptions, DescriptionsOf(world));
}

// Columns at the same place, of which nobody is lost that no event tells of.
class Census {
 public:
  explicit Census(const World& world) : entities_(world.entity_count()), joints_(world.joint_count()) {}

  void Expect(World& world) {
    size_t broken = 0;
    for (const Event& event : world.TakeEvents()) {
      EXPECT_FALSE(std::holds_alternative<EntityFaulted>(event.kind)) << "at step " << event.step;
      broken += std::holds_alternative<JointBroke>(event.kind);
    }
    EXPECT_FALSE(world.faulted());
    EXPECT_EQ(world.entity_count(), entities_);
    EXPECT_EQ(world.joint_count() + broken, joints_);
    joints_ -= broken;
    EXPECT_TRUE(world.state().positions.allFinite() && world.state().linear_velocities.allFinite());
  }

 private:
  size_t entities_, joints_;
};

// Presets mean other substeps on other engines.
double LongestSubstep(const World& world) {
  const StepperDesc& stepper = world.scene().world.stepper;
  uint32_t fewest = ~0u;
  for (const std::string& engine : EveryEngineWithContacts()) {
    fewest = std::min(fewest, EveryEngine().Find(engine)->Resolve(stepper).substeps);
  }
  return stepper.step_size / fewest;
}

void ExpectThoseApartAsEver(const RandomScene& scene) {
  const World& world = *scene.world;
  for (size_t i = 0; i < scene.sleepers.size(); ++i) {
    EXPECT_TRUE(Asleep(world, scene.sleepers[i])) << "sleeper " << i;
    EXPECT_EQ(VelocityOf(world, scene.sleepers[i]).norm(), 0);
  }
  if (!scene.hook.is_null()) {
    // A substep goes straight on along the tangent: by (v h)^2 / 2 r off the circle of 1 m, at no more speed than that
    // of the start and of a fall through its radius.
    const double square = 1 + 2 * world.scene().world.gravity.norm();
    EXPECT_LE(GapOf(world, scene.hook), 2 * square * std::pow(LongestSubstep(world), 2) / 2);
  }
  const double step = world.scene().world.stepper.step_size;
  const double pushed = std::min<double>(static_cast<double>(world.layer_state().step), scene.push_steps);
  EXPECT_LE((VelocityOf(world, scene.flyer) - pushed * step * scene.push).norm(), kRounding);
}

TEST_P(EngineChangeOfRandomScenes, LosesNothingThereAndBack) {
  size_t bodies = 0, joints = 0, asleep = 0, forces = 0, touching = 0;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    RandomScene scene = MakeRandomScene({GetParam(), OtherEngine(GetParam())}, seed);
    World& world = *scene.world;
    Census census(world);
    Random random(seed ^ 0x5eed);
    // The sleepers need a tenth of a second and the slowest world steps 120 times in one.
    Steps(world, static_cast<int>(30 + random.Below(40)));
    census.Expect(world);
    ExpectThoseApartAsEver(scene);
    const std::vector<Vector3> lies = {PositionOf(world, scene.sleepers[0]), PositionOf(world, scene.sleepers[1])};
    asleep += static_cast<size_t>(std::count(world.state().asleep.begin(), world.state().asleep.end(), uint8_t{1}));
    bodies += world.entity_count();
    joints += world.joint_count();
    forces += world.layer_state().forces.size();
    touching += TouchingIn(world).size();

    for (const std::string& engine : {OtherEngine(GetParam()), GetParam()}) {
      Change(world, engine);
      Steps(world, static_cast<int>(random.Below(20)));
      census.Expect(world);
      ExpectThoseApartAsEver(scene);
    }
    for (size_t i = 0; i < lies.size(); ++i) EXPECT_EQ(PositionOf(world, scene.sleepers[i]), lies[i]);
    if (HasFailure()) return;
  }
  // The scenes are about something.
  EXPECT_GT(bodies, 10 * kScenes);
  if (!ThoseWith({Feature::kJointHinge}, {GetParam()}).empty()) {
    EXPECT_GT(joints, 2 * kScenes);
  }
  EXPECT_GE(asleep, 3 * kScenes);
  EXPECT_GT(forces, kScenes);
  EXPECT_GT(touching, 5 * kScenes);
}

}  // namespace
}  // namespace genphys::testing

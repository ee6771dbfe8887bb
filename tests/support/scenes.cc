#include "support/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_split.h"
#include "genphys/backends/spheres.h"
#include "genphys/builtin_backends.h"

namespace genphys::testing {

const BackendRegistry& Engines() {
  static const BackendRegistry registry = BuiltinBackends();
  return registry;
}

const BackendRegistry& EveryEngine() {
  static const BackendRegistry registry = [] {
    BackendRegistry engines = BuiltinBackends();
    engines.Add(MakeSpheresBackend());
    return engines;
  }();
  return registry;
}

namespace {

std::vector<std::string> NamesOf(const BackendRegistry& registry) {
  std::vector<std::string> names;
  for (const auto& backend : registry.backends()) names.push_back(backend->capabilities().engine());
  return names;
}

thread_local std::string ending_at;  // refusals of this engine
thread_local std::string refused;

// The features that `message` names, if it is what the core says of `engine` and that has none of them.
std::string MissingFeaturesIn(const std::string& message, const std::string& engine) {
  const std::string opening = "engine \"" + engine + "\" does not support ";
  const size_t place = message.find(opening);
  if (place == std::string::npos) return "";
  const Capabilities& capabilities = EveryEngine().Find(engine)->capabilities();
  std::string names;
  for (const std::string& name :
       std::vector<std::string>(absl::StrSplit(message.substr(place + opening.size()), ", "))) {
    bool is_missing = false;
    for (size_t i = 0; i < static_cast<size_t>(Feature::kCount); ++i) {
      const auto feature = static_cast<Feature>(i);
      is_missing |= NameOf(feature) == name && !capabilities.Has(feature);
    }
    if (!is_missing) return "";
    names += name + ' ';
  }
  return names;
}

}  // namespace

std::vector<std::string> EnginesWithContacts() { return ThoseWith({Feature::kContacts}, NamesOf(Engines())); }

std::vector<std::string> EveryEngineName() { return NamesOf(EveryEngine()); }

std::vector<std::string> EveryEngineWithContacts() { return ThoseWith({Feature::kContacts}, NamesOf(EveryEngine())); }

std::vector<std::string> ThoseWith(std::initializer_list<Feature> features, const std::vector<std::string>& engines) {
  std::vector<std::string> able;
  for (const std::string& name : engines) {
    const Capabilities& capabilities = EveryEngine().Find(name)->capabilities();
    const auto has = [&](Feature feature) { return capabilities.Has(feature); };
    if (std::all_of(features.begin(), features.end(), has)) able.push_back(name);
  }
  return able;
}

void EndAtRefusalsOf(const std::string& engine) { ending_at = engine; }

void EndAtRefusal(const Status& status) {
  const std::optional<Refusal> refusal = RefusalOf(status);
  if (ending_at.empty() || !refusal || refusal->reason != Reason::kUnsupportedFeature) return;
  const std::string names = MissingFeaturesIn(MessageOf(status), ending_at);
  if (names.empty()) return;
  refused += names;
  // GoogleTest's own way to leave a test from below it, which tells nothing to anybody.
  throw ::testing::AssertionException(
      ::testing::TestPartResult(::testing::TestPartResult::kSuccess, __FILE__, __LINE__, "refused by name"));
}

std::string TakeRefused() { return std::exchange(refused, {}); }

std::string OtherEngine(const std::string& engine) {
  for (const std::string& name : EnginesWithContacts()) {
    if (name != engine) return name;
  }
  ADD_FAILURE() << "there is no other engine than " << engine;
  return engine;
}

std::unique_ptr<World> MakeWorld(const WorldDesc& desc) {
  Result<std::unique_ptr<World>> world = World::Create(EveryEngine(), desc);
  EndAtRefusal(world.status());
  EXPECT_TRUE(world.ok()) << world.status();
  const bool may_refuse = !ending_at.empty() && desc.ground_plane.value_or(true);
  if (world.ok() && may_refuse) Require(**world, Feature::kContacts);
  return world.ok() ? std::move(*world) : nullptr;
}

void Require(const World& world, Feature feature) {
  const std::string& engine = world.scene().world.engine;
  const auto* const backend = EveryEngine().Find(engine);
  if (backend == nullptr || backend->capabilities().Has(feature)) return;  // "none" is asked for nothing
  const WorldDesc desc{.engine = engine, .ground_plane = false, .required_features = {feature}};
  const Status status = World::Create(EveryEngine(), desc).status();
  EndAtRefusal(status);
  EXPECT_TRUE(status.ok()) << status;
}

std::unique_ptr<World> MakeWorld(const std::string& engine) {
  return MakeWorld(WorldDesc{.engine = engine, .gravity = {0, 0, -9.81}});
}

EntityDesc Body(const Shape& shape, const Vector3& position, double mass) {
  EntityDesc desc;
  desc.pose.position = position;
  desc.rigid_body = RigidBody{.geometries = {Geometry{.shape = shape}}, .inertia = {.mass = mass}};
  return desc;
}

EntityDesc Ball(const Vector3& position, double radius, double mass) { return Body(Sphere{radius}, position, mass); }

EntityDesc Crate(const Vector3& position, double half_extent, double mass) {
  return Body(Box{Vector3::Constant(half_extent)}, position, mass);
}

EntityDesc Block(const Vector3& position, const Vector3& half_extents) {
  EntityDesc desc = Body(Box{half_extents}, position);
  desc.rigid_body->motion_type = MotionType::kStatic;
  return desc;
}

CreatedId Do(World& world, const Command& command) {
  const Result<std::vector<CreatedId>> created = world.Apply({&command, 1});
  EndAtRefusal(created.status());
  EXPECT_TRUE(created.ok()) << created.status();
  return created.ok() ? created->front() : CreatedId();
}

EntityId Add(World& world, const EntityDesc& desc) { return Do(world, CreateEntity{desc}); }

void Steps(World& world, int count) {
  for (int i = 0; i < count; ++i) {
    const Status status = world.Step();
    ASSERT_TRUE(status.ok()) << status;
  }
}

double SubstepOf(const World& world) {
  const StepperDesc& stepper = world.scene().world.stepper;
  return stepper.step_size / EveryEngine().Find(world.scene().world.engine)->Resolve(stepper).substeps;
}

Vector3 PositionOf(const World& world, EntityId id) { return world.state().positions.col(id.index()); }
Vector3 VelocityOf(const World& world, EntityId id) { return world.state().linear_velocities.col(id.index()); }
Vector3 SpinOf(const World& world, EntityId id) { return world.state().angular_velocities.col(id.index()); }
bool Asleep(const World& world, EntityId id) { return world.state().asleep[id.index()] != 0; }

std::vector<TouchingPair> TouchingIn(const World& world) {
  std::vector<TouchingPair> all = world.layer_state().touching;
  const std::vector<TouchingPair> lying = world.layer_state().lying.Sorted();
  all.insert(all.end(), lying.begin(), lying.end());
  return all;
}

}  // namespace genphys::testing

#include "support/scenes.h"

#include <gtest/gtest.h>

#include "genphys/builtin_backends.h"

namespace genphys::testing {

const BackendRegistry& Engines() {
  static const BackendRegistry registry = BuiltinBackends();
  return registry;
}

std::vector<std::string> EnginesWithContacts() {
  std::vector<std::string> names;
  for (const auto& backend : Engines().backends()) {
    if (backend->capabilities().Has(Feature::kContacts)) names.push_back(backend->capabilities().engine());
  }
  return names;
}

std::string OtherEngine(const std::string& engine) {
  for (const std::string& name : EnginesWithContacts()) {
    if (name != engine) return name;
  }
  return engine;
}

std::unique_ptr<World> MakeWorld(const WorldDesc& desc) {
  Result<std::unique_ptr<World>> world = World::Create(Engines(), desc);
  EXPECT_TRUE(world.ok()) << world.status();
  return world.ok() ? std::move(*world) : nullptr;
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

Vector3 PositionOf(const World& world, EntityId id) { return world.state().positions.col(id.index()); }
Vector3 VelocityOf(const World& world, EntityId id) { return world.state().linear_velocities.col(id.index()); }
Vector3 SpinOf(const World& world, EntityId id) { return world.state().angular_velocities.col(id.index()); }
bool Asleep(const World& world, EntityId id) { return world.state().asleep[id.index()] != 0; }

}  // namespace genphys::testing

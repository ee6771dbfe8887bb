#pragma once
#include <memory>
#include <string>
#include <vector>

#include "genphys/world.h"

namespace genphys::testing {

/// All engines of this build, shared by every test of the program.
const BackendRegistry& Engines();

/// Short names of the engines that know contacts: what conformance tests run on.
std::vector<std::string> EnginesWithContacts();

/// Another of these than `engine`, or that one if there is no other.
std::string OtherEngine(const std::string& engine);

/// A world on `engine` with earth's gravity 9.81 m/s^2 and a floor, or a failure of the test.
std::unique_ptr<World> MakeWorld(const std::string& engine);
std::unique_ptr<World> MakeWorld(const WorldDesc& desc);

/// Dynamic bodies of one geometry at `position`, of `mass` kg.
EntityDesc Body(const Shape& shape, const Vector3& position, double mass = 1);
EntityDesc Ball(const Vector3& position, double radius = 0.5, double mass = 1);
EntityDesc Crate(const Vector3& position, double half_extent = 0.5, double mass = 1);
/// A static box.
EntityDesc Block(const Vector3& position, const Vector3& half_extents);

/// Applies one command that must be accepted; returns the id it created, if any.
CreatedId Do(World& world, const Command& command);
EntityId Add(World& world, const EntityDesc& desc);

/// Takes `count` steps that must succeed.
void Steps(World& world, int count);

Vector3 PositionOf(const World& world, EntityId id);
Vector3 VelocityOf(const World& world, EntityId id);
Vector3 SpinOf(const World& world, EntityId id);
bool Asleep(const World& world, EntityId id);

/// Those of `events` that are of kind T, in order.
template <typename T>
std::vector<T> Of(const std::vector<Event>& events) {
  std::vector<T> found;
  for (const Event& event : events) {
    if (const T* kind = std::get_if<T>(&event.kind)) found.push_back(*kind);
  }
  return found;
}

}  // namespace genphys::testing

#pragma once
#include <memory>
#include <string>
#include <vector>

#include "genphys/world.h"

namespace genphys::testing {

/// The engines that the server of this build offers, shared by every test of the program.
const BackendRegistry& Engines();

/// These, and those that are built for tests alone.
const BackendRegistry& EveryEngine();

/// Short names of the server's engines that know contacts.
std::vector<std::string> EnginesWithContacts();

/// Short names of all engines: what conformance tests run on.
std::vector<std::string> EveryEngineName();

/// Of these, those that know contacts.
std::vector<std::string> EveryEngineWithContacts();

/// Those of `engines` that have all of `features`.
std::vector<std::string> ThoseWith(std::initializer_list<Feature> features, const std::vector<std::string>& engines);

/// One of the server's engines that is not `engine`, or a failure of the test.
std::string OtherEngine(const std::string& engine);

/// From now on a refusal that names features which `engine` lacks ends the test that led to it; of none, if that is
/// empty. Conformance tests say so of the engine that they run on, on their own thread: what another one lacks is a
/// failure.
void EndAtRefusalsOf(const std::string& engine);

/// Ends the test if `status` is such a refusal, which is on record then. Goes on if it is anything else.
void EndAtRefusal(const Status& status);

/// Ends the test if the engine of `world` lacks `feature`, as what it says to a world that requires it tells.
void Require(const World& world, Feature feature);

/// Names of the features that were refused since the last call.
std::string TakeRefused();

/// A world on `engine` with earth's gravity 9.81 m/s^2 and a floor, or a failure of the test. In conformance
/// tests, where a floor is wanted or nothing is said, it is one that holds: engines without contacts refuse.
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

/// Seconds of one solve.
double SubstepOf(const World& world);

Vector3 PositionOf(const World& world, EntityId id);
Vector3 VelocityOf(const World& world, EntityId id);
Vector3 SpinOf(const World& world, EntityId id);
bool Asleep(const World& world, EntityId id);

/// Who touches whom, asleep or not.
std::vector<TouchingPair> TouchingIn(const World& world);

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

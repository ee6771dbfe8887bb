#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "contenders/scene.h"
#include "genphys/command.h"
#include "genphys/registry.h"
#include "genphys/world.h"

namespace genphys::bench {

/// A world of ours in this process. Failures are std::runtime_errors.
class LocalWorld {
 public:
  /// `registry` must outlive it.
  LocalWorld(const BackendRegistry& registry, const WorldDesc& desc, std::span<const EntityDesc> entities);

  EntityId Add(const EntityDesc& entity);
  void Apply(const Command& command);
  void Step();
  /// Steps until so many entities sleep.
  void AwaitSleep(size_t count);
  size_t asleep() const;
  /// Takes a step and says where its work went.
  StepStats Explain();

  World& world() { return *world_; }
  const World& world() const { return *world_; }
  /// Of the entities that it was made with, in their order.
  const std::vector<EntityId>& ids() const { return ids_; }

 private:
  std::unique_ptr<World> world_;
  std::vector<EntityId> ids_;
};

/// A box of 1 kg.
EntityDesc BoxOf(const Vector3& position, const Vector3& half_extents = Vector3::Constant(0.5));

/// The bodies of a scene as they lie when they have come to rest on `engine`.
std::vector<EntityDesc> Settled(const BackendRegistry& registry, const std::string& engine, const Scene& scene);

/// "10,000"
std::string WithCommas(size_t number);

}  // namespace genphys::bench

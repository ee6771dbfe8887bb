#include "local_world.h"

#include <algorithm>
#include <stdexcept>

#include "genphys/client/client.h"
#include "support/must.h"

namespace genphys::bench {
namespace {

// Creations in one batch.
constexpr size_t kBatch = 1000;
// s of the world: who is not asleep by then never will be.
constexpr double kSleepTimeMax = 60;

}  // namespace

LocalWorld::LocalWorld(const BackendRegistry& registry, const WorldDesc& desc, std::span<const EntityDesc> entities)
    : world_(Must(World::Create(registry, desc))) {
  for (size_t first = 0; first < entities.size(); first += kBatch) {
    std::vector<Command> commands;
    for (const EntityDesc& entity : entities.subspan(first, std::min(kBatch, entities.size() - first))) {
      commands.push_back(CreateEntity{entity});
    }
    const std::vector<CreatedId> created = Must(world_->Apply(commands));
    ids_.insert(ids_.end(), created.begin(), created.end());
    world_->TakeEvents();
  }
}

EntityId LocalWorld::Add(const EntityDesc& entity) {
  const Command command = CreateEntity{entity};
  return Must(world_->Apply({&command, 1})).front();
}

void LocalWorld::Apply(const Command& command) { Must(world_->Apply({&command, 1})); }

void LocalWorld::Step() { Check(world_->Step()); }

void LocalWorld::AwaitSleep(size_t count) {
  const double end = world_->layer_state().simulation_time + kSleepTimeMax;
  while (asleep() < count) {
    if (world_->layer_state().simulation_time > end) {
      throw std::runtime_error("only " + std::to_string(asleep()) + " of " + std::to_string(count) + " fell asleep");
    }
    Step();
  }
  world_->TakeEvents();
}

size_t LocalWorld::asleep() const {
  const std::vector<uint8_t>& asleep = world_->state().asleep;
  return static_cast<size_t>(std::count(asleep.begin(), asleep.end(), uint8_t{1}));
}

StepStats LocalWorld::Explain() {
  world_->set_record_stats(true);
  Step();
  world_->set_record_stats(false);
  return world_->stats();
}

EntityDesc BoxOf(const Vector3& position, const Vector3& half_extents) {
  return client::Body(Box{half_extents}, {.position = position, .mass = 1});
}

std::vector<EntityDesc> Settled(const BackendRegistry& registry, const std::string& engine, const Scene& scene) {
  LocalWorld local(registry, {.engine = engine}, scene.bodies);
  local.AwaitSleep(scene.bodies.size());
  std::vector<EntityDesc> settled;
  for (const EntityId id : local.ids()) settled.push_back(Must(local.world().Describe(id)));
  return settled;
}

std::string WithCommas(size_t number) {
  std::string text = std::to_string(number);
  for (size_t place = text.size(); place > 3;) text.insert(place -= 3, 1, ',');
  return text;
}

}  // namespace genphys::bench

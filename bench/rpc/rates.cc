#include "rates.h"

#include <chrono>
#include <cstdio>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "contenders.h"
#include "genphys/client/client.h"
#include "scenes.h"

namespace genphys::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kCalls = 100;  // of which the first warm it up
constexpr int kCallsDropped = 10;
constexpr int kBatches = 20;

double SecondsSince(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

Scene Floating(const std::string& engine, uint32_t count) {
  Scene scene{.name = "floating", .world = {.engine = engine}};
  scene.world.ground_plane = false;
  scene.world.gravity = Vector3::Zero();
  for (uint32_t i = 0; i < count; ++i) {
    scene.entities.push_back(client::Body(Sphere{.radius = 0.4}, {.position = {2.0 * (i % 32), 2.0 * (i / 32), 0}}));
  }
  return scene;
}

Spread Forces(const Parties& parties, const std::string& engine) {
  client::World world = MakeWorld(parties.address, Floating(engine, kRateRows));
  client::StepOptions pushes{.frame = std::nullopt, .events = std::nullopt};
  ApplyForceColumns columns;
  for (const client::EntityInfo& entity : Must(world.ListEntities())) {
    columns.ids.push_back(entity.id);
    columns.forces.push_back({0, 0, 1});
  }
  pushes.commands.push_back(columns);
  std::vector<double> rates;
  for (int i = 0; i < kCalls; ++i) {
    const Clock::time_point begin = Clock::now();
    Must(world.Step(0, pushes));
    if (i >= kCallsDropped) rates.push_back(kRateRows / SecondsSince(begin));
    // Used up, or they would pile up.
    Must(world.Step(1, {.frame = std::nullopt, .events = std::nullopt}));
  }
  return SpreadOf(rates);
}

Spread Creations(const Parties& parties, const std::string& engine) {
  std::vector<double> rates;
  for (int i = 0; i < kBatches; ++i) {
    const Scene scene = Floating(engine, kRateRows);
    std::vector<Command> commands;
    for (const EntityDesc& entity : scene.entities) commands.push_back(CreateEntity{entity});
    client::World world = MakeWorld(parties.address, Floating(engine, 0));
    const Clock::time_point begin = Clock::now();
    Must(world.Apply(commands));
    rates.push_back(kRateRows / SecondsSince(begin));
  }
  return SpreadOf(rates);
}

// Of sleepers, whose step costs so little that what comes on top is seen.
Spread Unwatched(const Parties& parties, const std::string& engine) {
  constexpr uint32_t kSteps = 10'000;
  constexpr int kRounds = 20;
  const Scene scene = Scenes(engine).front();
  InProcess in_process(parties.registry, scene);
  client::World served = MakeWorld(parties.address, scene);
  const client::StepOptions unwatched{.frame = std::nullopt, .events = std::nullopt};
  in_process.Advance(scene.steps_before);
  Must(served.Step(scene.steps_before, unwatched));
  std::vector<double> costs;
  for (int i = 0; i < kRounds; ++i) {
    const Clock::time_point begin = Clock::now();
    in_process.Advance(kSteps);
    const double alone = SecondsSince(begin);
    const Clock::time_point middle = Clock::now();
    Must(served.Step(kSteps, unwatched));
    costs.push_back(1e9 * (SecondsSince(middle) - alone) / kSteps / kSceneEntities);
  }
  return SpreadOf(costs);
}

// What python_client.py answers to a line that begins with `what`.
Spread AskPython(ChildProcess& python, const std::string& what, const client::World& world) {
  python.Write(what + ' ' + world.name() + ' ' + std::to_string(kCalls) + '\n');
  std::istringstream line(python.ReadLine());
  std::vector<double> values;
  for (double value = 0; line >> value;) values.push_back(value);
  if (values.empty()) throw std::runtime_error("the Python client measured nothing");
  return SpreadOf(values);
}

}  // namespace

Rates MeasureRates(const Parties& parties, const std::string& engine) {
  std::fprintf(stderr, "%-8s rates\n", engine.c_str());
  Rates rates;
  rates.forces_cpp = Forces(parties, engine);
  rates.creations = Creations(parties, engine);
  rates.unwatched = Unwatched(parties, engine);
  client::World many = MakeWorld(parties.address, Floating(engine, kRateRows));
  client::World one = MakeWorld(parties.address, Floating(engine, 1));
  rates.forces_python = AskPython(parties.python, "forces", many);
  rates.frame_to_numpy = AskPython(parties.python, "numpy", many);
  rates.small_frames = AskPython(parties.python, "frames", one);
  return rates;
}

}  // namespace genphys::bench

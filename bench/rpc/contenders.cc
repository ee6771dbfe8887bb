#include "contenders.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "genphys/v1/simulation_service.grpc.pb.h"

namespace genphys::bench {
namespace {

using Clock = std::chrono::steady_clock;

template <typename Work>
Times Timed(uint32_t count, Work work) {
  Times times(count);
  for (double& time : times) {
    const Clock::time_point begin = Clock::now();
    work();
    time = std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
  }
  return times;
}

std::vector<Command> Creations(const Scene& scene) {
  std::vector<Command> commands;
  for (const EntityDesc& entity : scene.entities) commands.push_back(CreateEntity{entity});
  return commands;
}

void AdvanceByCalls(client::World& world, uint32_t steps) {
  // In calls short enough for the deadline of each, whatever a step costs.
  constexpr uint32_t kStepsPerCall = 20;
  for (uint32_t done = 0; done < steps; done += kStepsPerCall) Must(world.Step(std::min(kStepsPerCall, steps - done)));
}

}  // namespace

client::World MakeWorld(const std::string& address, const Scene& scene) {
  const client::Server server = Must(client::Connect(address));
  client::World world = Must(server.CreateWorld({.world = scene.world}));
  Must(world.Apply(Creations(scene)));
  return world;
}

void CheckSame(const StateArrays& state, const client::Frame& frame, const std::string& whose) {
  const auto entities = state.ids.size() - std::count(state.ids.begin(), state.ids.end(), EntityId());
  bool same = frame.rows() == entities;
  for (uint32_t i = 0; same && i < frame.rows(); ++i) {
    const uint32_t row = frame.ids()[i].index();
    same = row < state.rows() && state.ids[row] == frame.ids()[i] &&
           state.positions.col(row) == frame.positions().col(i) &&
           state.orientations.col(row) == frame.orientations().col(i) &&
           state.linear_velocities.col(row) == frame.linear_velocities().col(i) &&
           state.angular_velocities.col(row) == frame.angular_velocities().col(i);
  }
  if (!same) throw std::runtime_error("the world of the " + whose + " is not where the one in this process is");
}

InProcess::InProcess(const BackendRegistry& registry, const Scene& scene)
    : world_(Must(World::Create(registry, scene.world))) {
  Must(world_->Apply(Creations(scene)));
}

void InProcess::StepOnce() {
  Check(world_->Step());
  // Somebody has to take them, or they would pile up.
  world_->TakeEvents();
}

void InProcess::Advance(uint32_t steps) {
  for (uint32_t i = 0; i < steps; ++i) StepOnce();
}

Times InProcess::Measure(uint32_t steps) {
  return Timed(steps, [&] { StepOnce(); });
}

CppCycle::CppCycle(const std::string& address, const Scene& scene)
    : world_(MakeWorld(address, scene)), channel_(grpc::CreateChannel(address, grpc::InsecureChannelCredentials())) {}

void CppCycle::Advance(uint32_t steps) { AdvanceByCalls(world_, steps); }

Times CppCycle::Measure(uint32_t steps) {
  return Timed(steps, [&] { Must(world_.Step()); });
}

Exchange CppCycle::Capture() {
  v1::StepRequest request;
  request.set_world(world_.name());
  request.set_steps(1);
  request.mutable_frame()->set_scalar(v1::SCALAR_FLOAT64);
  request.mutable_frame()->set_poses(true);
  request.mutable_frame()->set_velocities(true);
  request.mutable_events();
  // As long as those of the client. Each is new: a known one would not step.
  const std::string number = std::to_string(Clock::now().time_since_epoch().count());
  request.set_request_id(number + std::string(28 - std::min<size_t>(number.size(), 28), '-'));
  grpc::ClientContext context;
  v1::StepResponse response;
  const grpc::Status status = v1::SimulationService::NewStub(channel_)->Step(&context, request, &response);
  if (!status.ok()) throw std::runtime_error("the step failed: " + status.error_message());
  return {request.SerializeAsString(), response.SerializeAsString()};
}

client::Frame CppCycle::Look() { return Must(world_.Step(0)).frame; }

PythonCycle::PythonCycle(ChildProcess& python, const std::string& address, const Scene& scene)
    : python_(python), world_(MakeWorld(address, scene)) {}

void PythonCycle::Advance(uint32_t steps) { AdvanceByCalls(world_, steps); }

Times PythonCycle::Measure(uint32_t steps) {
  python_.Write("cycle " + world_.name() + ' ' + std::to_string(steps) + '\n');
  std::istringstream line(python_.ReadLine());
  Times times;
  for (double nanoseconds = 0; line >> nanoseconds;) times.push_back(nanoseconds / 1000);
  if (times.size() != steps) throw std::runtime_error("the Python client did not measure what it was told to");
  return times;
}

client::Frame PythonCycle::Look() { return Must(world_.Step(0)).frame; }

CppDrive::CppDrive(const std::string& address, const Scene& scene)
    : world_(MakeWorld(address, scene)), drive_(world_.OpenDrive()) {}

void CppDrive::Advance(uint32_t steps) { AdvanceByCalls(world_, steps); }

Times CppDrive::Measure(uint32_t run_in, uint32_t steps) {
  constexpr uint32_t kInFlight = 2;
  const uint32_t first = std::max(run_in, kInFlight), last = run_in + steps - kInFlight + 1;
  for (uint32_t i = 0; i < kInFlight; ++i) Check(drive_.Send());
  Clock::time_point begin, end;
  for (uint32_t received = 1; received <= run_in + steps; ++received) {
    Must(drive_.Receive());
    if (received == first) begin = Clock::now();
    if (received == last) end = Clock::now();
    if (received + kInFlight <= run_in + steps) Check(drive_.Send());
  }
  return {std::chrono::duration<double, std::micro>(end - begin).count() / (last - first)};
}

client::Frame CppDrive::Look() { return Must(world_.Step(0)).frame; }

Times MeasureEcho(Echo& echo, uint32_t steps) {
  return Timed(steps, [&] { echo.Call(); });
}

}  // namespace genphys::bench

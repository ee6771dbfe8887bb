#pragma once
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "genphys/command.h"
#include "genphys/entity.h"
#include "genphys/event.h"
#include "genphys/ids.h"
#include "genphys/scene.h"

namespace genphys::client {

/// How long every call that is no stream may take, unless told otherwise.
inline constexpr std::chrono::milliseconds kDefaultDeadline{30'000};

struct ConnectOptions {
  std::chrono::milliseconds deadline = kDefaultDeadline;  // of each call that is no stream
  std::chrono::milliseconds connect_timeout{5'000};       // for the first connection: a server may be just starting
};

/// A new world; what is left out has the server's default.
struct WorldOptions {
  std::string name;                // "demo" is worlds/demo; empty: the server makes one up
  WorldDesc world{.engine = ""};   // an empty engine is the server's default
  bool record_state_hash = false;  // put a state hash into every stamp
  bool keep = false;               // leave the world on the server when its handle goes
};

/// A new entity of one geometry, in SI units and world coordinates. Name members to leave the others at their defaults:
/// `world.Add(Sphere{.radius = 0.5}, {.position = {0, 0, 5}, .mass = 1})`.
struct BodyOptions {
  std::string display_name;
  Vector3 position = Vector3::Zero();
  Quaternion orientation = Quaternion::Identity();
  std::optional<double> mass;     // kg; unset: from the volume and the density
  std::optional<double> density;  // kg/m^3
  std::optional<double> friction;
  std::optional<double> restitution;
  std::optional<double> rolling_friction;   // m
  std::optional<double> spinning_friction;  // m
  MotionType motion_type = MotionType::kDynamic;
  Vector3 linear_velocity = Vector3::Zero();   // m/s
  Vector3 angular_velocity = Vector3::Zero();  // rad/s
  double linear_damping = 0;                   // 1/s
  double angular_damping = 0;                  // 1/s
  double gravity_scale = 1;                    // part of the world's gravity that acts on it
  LockedAxes locked_axes;                      // of the world, along and about which it does not move
  bool is_sensor = false;
  Vector3 surface_velocity = Vector3::Zero();  // m/s, in the entity's frame: the surface runs like a belt
  std::string collision_space;
  std::optional<Visual> visual;
};

/// The description that `options` stand for; change it freely before World::Create().
EntityDesc Body(const Shape& shape, const BodyOptions& options = {});

/// Which columns a frame has. What is not asked for is not computed.
struct FrameOptions {
  bool poses = true;
  bool velocities = true;
  bool net_forces = false;
  bool joints = false;             // what all joints of the world are doing
  bool deltas = false;             // only rows that changed are sent; the frames that come out are whole all the same
  std::vector<EntityId> entities;  // empty: all
};

/// Which events to send.
struct EventOptions {
  std::optional<EventKinds> kinds;  // unset: all that the world records
  std::vector<EntityId> entities;   // events that name one of these; empty: all
};

/// What goes with a call of World::Step().
struct StepOptions {
  std::vector<Command> commands;                        // applied in order before the first step, or none at all
  std::optional<double> step_size;                      // s, of each of these steps; unset: the stepper's
  std::optional<FrameOptions> frame = FrameOptions{};   // after the last step; unset: none
  std::optional<EventOptions> events = EventOptions{};  // of the commands and all steps; unset: none
  bool stats = false;                                   // of the last step
  std::optional<uint64_t> expected_step;                // refused with STEP_MISMATCH unless the world is there
  std::optional<std::chrono::milliseconds> deadline;    // unset: the connection's
};

/// How far a listener has come, to go on from there later.
struct StreamPosition {
  uint64_t epoch = 0;
  uint64_t sequence = 0;  // of the last event received
};

struct WatchOptions {
  EventOptions events;
  std::optional<StreamPosition> after;  // unset: from now on
};

}  // namespace genphys::client

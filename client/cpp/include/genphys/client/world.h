#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "genphys/client/frame.h"
#include "genphys/client/options.h"
#include "genphys/client/stats.h"
#include "genphys/client/streams.h"
#include "genphys/command.h"
#include "genphys/event.h"
#include "genphys/query.h"
#include "genphys/scene.h"
#include "genphys/status.h"

namespace genphys::v1 {
class StepRequest;
class StepResponse;
}  // namespace genphys::v1

namespace genphys::client {

class Connection;
class Drive;
class Keyframes;

/// What came of a step.
struct StepResult {
  Stamp stamp;                     // after the last step
  std::vector<CreatedId> created;  // one per command, null where it created nothing
  Frame frame;                     // without rows unless asked for
  std::vector<Event> events;       // if asked for
  uint64_t last_sequence = 0;      // of the last event looked at
  std::optional<Gap>
      events_left_out;         // set: these had no room in a reply, WatchEvents() after last_sequence tells them
  std::optional<Stats> stats;  // of the last of these steps, if asked for
};

/// What a world is and where it stands.
struct WorldInfo {
  enum class State { kPaused, kPlaying, kFaulted };
  WorldDesc world;
  bool record_state_hash = false;
  State state = State::kPaused;
  Stamp stamp;
};

/// An entity with its id, as it was when asked for.
struct EntityInfo {
  EntityId id;
  EntityDesc entity;
};

/// A joint with its id, and what it was doing when asked for.
struct JointInfo {
  JointId id;
  JointDesc joint;
  JointState state;
};

/// A force field with its id.
struct ForceFieldInfo {
  ForceFieldId id = 0;
  ForceField field;
};

/// A world on a server. Safe to use from several threads. A refusal has the reason and the field path that the server
/// gave it: see RefusalOf(). Failures of the connection are UNAVAILABLE and DEADLINE_EXCEEDED; a retry that could
/// change the world twice is recognised by the server.
class World {
 public:
  World(World&& other) noexcept;
  World& operator=(World&& other) noexcept;
  /// Deletes the world if this handle made it and was not told to keep it; errors of that are lost.
  ~World();

  /// As in "worlds/demo".
  const std::string& name() const { return name_; }
  Result<WorldInfo> Info() const;
  /// Deletes it now.
  Status Delete();
  /// Leaves it on the server when this handle goes.
  void Keep() { owned_ = false; }

  /// Adds an entity of one geometry.
  Result<EntityId> Add(const Shape& shape, const BodyOptions& options = {});
  /// Adds any entity.
  Result<EntityId> Create(const EntityDesc& entity);
  /// Replaces the named fields of an entity: physics, a visual, geometries and all else come and go while it lives.
  Status Update(EntityId id, const EntityDesc& entity, EntityFields fields);
  Status Remove(EntityId id);
  /// An entity as it is now: description with current pose and velocities.
  Result<EntityDesc> Describe(EntityId id) const;
  /// All of them, in order of id.
  Result<std::vector<EntityInfo>> ListEntities() const;

  /// Joins two entities, or one to the world.
  Result<JointId> Join(const JointDesc& joint);
  /// Replaces the named fields of a joint.
  Status UpdateJoint(JointId id, const JointDesc& joint, JointFields fields);
  Status Unjoin(JointId id);
  /// All of them, in order of id.
  Result<std::vector<JointInfo>> ListJoints() const;

  /// Adds a force field, which acts until it is removed.
  Result<ForceFieldId> AddField(const ForceField& field);
  /// Replaces all of a force field.
  Status UpdateField(ForceFieldId id, const ForceField& field);
  Status RemoveField(ForceFieldId id);
  /// All of them, in order of id.
  Result<std::vector<ForceFieldInfo>> ListForceFields() const;

  Status ApplyForce(const genphys::ApplyForce& force);
  Status ApplyImpulse(const genphys::ApplyImpulse& impulse);
  Status SetVelocity(const genphys::SetVelocity& velocity);
  Status SetPose(const genphys::SetPose& pose);
  /// m/s^2, world.
  Status SetGravity(const Vector3& gravity);
  Status SetStepper(const StepperDesc& stepper);
  /// Moves the world to another engine between two steps, state kept: "ode", "bullet", "none".
  Status SetEngine(const std::string& engine);
  /// All in order, or none. Returns, per command, the id that it created or null.
  Result<std::vector<CreatedId>> Apply(std::span<const Command> commands);

  /// Commands in, `steps` steps, a frame and events out, in one round trip.
  Result<StepResult> Step(uint32_t steps = 1, const StepOptions& options = {});
  /// Opens a stream of steps, for whoever does not want to wait for each; include "genphys/client/drive.h".
  Drive OpenDrive() const;

  /// Lets it move by itself: `real_time_factor` simulated seconds per second, zero for as fast as possible.
  Status Play(double real_time_factor = 1);
  Status Pause();
  /// Back to where its first step began, in a new epoch, without forces and what came along with that step. Ids of what
  /// was made after that are given out again.
  Status Reset();

  /// Closest hit of each ray among geometries in these categories; a miss has a null entity and the fraction 1.
  Result<std::vector<RayHit>> CastRays(std::span<const Ray> rays, uint64_t collides_with_bits = ~uint64_t{0}) const;

  /// Where each ray enters every geometry in these categories, in the order in which it meets them.
  Result<std::vector<std::vector<RayEntry>>> CastRaysThrough(std::span<const Ray> rays,
                                                             uint64_t collides_with_bits = ~uint64_t{0}) const;
  /// The first geometry that a bounded convex shape meets from each of `poses` along its translation, without turning.
  Result<std::vector<ShapeCastHit>> CastShape(const Shape& shape, std::span<const Pose> poses,
                                              std::span<const Vector3> translations,
                                              uint64_t collides_with_bits = ~uint64_t{0}) const;
  /// The geometries that a bounded convex shape overlaps at each of `poses`.
  Result<std::vector<std::vector<GeometryId>>> FindOverlaps(const Shape& shape, std::span<const Pose> poses,
                                                            uint64_t collides_with_bits = ~uint64_t{0}) const;
  /// The geometry nearest to a bounded convex shape at each of `poses`, up to `distance_max` (m) away.
  Result<std::vector<ClosestPoints>> FindClosest(const Shape& shape, std::span<const Pose> poses, double distance_max,
                                                 uint64_t collides_with_bits = ~uint64_t{0}) const;
  /// How far each entity of `from` is from that of `to`.
  Result<std::vector<ClosestPoints>> MeasureDistances(std::span<const EntityId> from,
                                                      std::span<const EntityId> to) const;
  /// What touches an entity as of the last step, with points and impulses.
  Result<std::vector<EntityContact>> ContactsOf(EntityId id) const;

  /// Events from now on, or after `options.after`. Returns once the server has the subscription, so that nothing that
  /// happens afterwards is missed.
  Result<EventStream> WatchEvents(const WatchOptions& options = {}) const;
  /// Frames of steps whose number is a multiple of `every_nth_step`.
  Result<FrameStream> WatchFrames(const FrameOptions& options = {}, uint32_t every_nth_step = 1) const;

 private:
  friend class Server;
  World(std::shared_ptr<Connection> connection, std::string name, bool owned);

  Result<std::shared_ptr<const v1::StepResponse>> CallStep(
      v1::StepRequest request, std::optional<std::chrono::milliseconds> deadline = std::nullopt) const;
  Status ApplyOne(Command command);

  std::shared_ptr<Connection> connection_;
  std::string name_;
  bool owned_ = false;
  std::shared_ptr<Keyframes> keyframes_;
};

}  // namespace genphys::client

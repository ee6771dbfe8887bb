#pragma once
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "genphys/backend.h"
#include "genphys/bounds.h"
#include "genphys/command.h"
#include "genphys/event.h"
#include "genphys/joint_index.h"
#include "genphys/layer_state.h"
#include "genphys/pair_rule.h"
#include "genphys/placement.h"
#include "genphys/query.h"
#include "genphys/registry.h"
#include "genphys/row_marks.h"
#include "genphys/row_set.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "genphys/status.h"
#include "genphys/step_stats.h"

namespace genphys {

class JointStep;
class NearPairs;
struct PreparedEntity;
class SleeperTree;
class StepUndo;
struct StepScratch;

/// One isolated world: changed only by Apply() and Step(), read only through its columns, contacts and events.
/// Not thread-safe; different worlds are independent.
class World {
 public:
  /// `registry` must outlive the world.
  static Result<std::unique_ptr<World>> Create(const BackendRegistry& registry, const WorldDesc& desc);
  ~World();

  /// Applies all `commands` in order at the current step boundary, or none: the first that is not valid is refused
  /// with the path commands[i].<field> and nothing has changed. Returns, per command, the id it created or null. What
  /// it has to tell comes in canonical order too, after what earlier batches at the same boundary had to. A WorkWatch
  /// that ends it while it checks ends it without effect, and later after as many commands as it returns ids for.
  Result<std::vector<CreatedId>> Apply(std::span<const Command> commands);

  /// Advances by one step of `step_size` seconds (unset: the stepper's). BUDGET_EXCEEDED undoes the step, and the world
  /// can be used as before; its hash is the one before unless the message says that the engine began anew. DIVERGED
  /// undoes it and faults the world: it can be read and reset, not stepped. Where a WorkWatch ends it, it is undone as
  /// one over the budget and returns what that says.
  Status Step(std::optional<double> step_size = std::nullopt);

  /// Whether steps do nothing but go on in time until somebody commands something.
  bool IsAtRest() const;

  /// Step(), `count` times, at the cost of counting them. Only for a world at rest that has stepped before.
  void StepAtRest(uint64_t count);

  /// Back to step 0, with all that was there at the beginning as it was, but for forces. Faulted if its engine fails.
  void Reset();
  /// Makes the present the beginning, unless there is one. So does the first step, which lets go of it if it is undone.
  void MarkBeginning();
  void ForgetBeginning();

  const Scene& scene() const { return scene_; }
  const StateArrays& state() const { return state_; }
  const LayerState& layer_state() const { return layer_; }
  /// Contact points at the current poses; the next step solves them.
  const ContactBuffer& contacts() const { return contacts_; }
  /// Grows whenever state() may have become another one; while it stays, only the step and the time go on.
  uint64_t changes() const { return changes_; }
  /// Rows that were awake, or driven, at any time in the last step or since: of all others steps have changed nothing.
  const RowSet& lately_active() const { return lately_active_; }
  bool faulted() const { return faulted_; }
  uint32_t entity_count() const { return entity_count_; }
  uint32_t joint_count() const { return joint_count_; }

  /// What a living joint is doing, as it is now.
  JointState joint_state(JointId id) const;

  /// What was recorded since the last call, in canonical order; the caller keeps it.
  std::vector<Event> TakeEvents();

  /// The entity as it is now: description with current pose and velocities.
  Result<EntityDesc> Describe(EntityId id) const;
  /// OK if `id` names a living entity, else ENTITY_NOT_FOUND or STALE_ID.
  Status CheckId(EntityId id, std::string_view field) const;
  /// The same of a joint.
  Status CheckId(JointId id, std::string_view field) const;

  // Long queries throw CutShort where a WorkWatch says so.

  /// Closest hits of `rays` among geometries in `collides_with_bits`. UNSUPPORTED_FEATURE without an engine that can.
  Result<std::vector<RayHit>> CastRays(std::span<const Ray> rays, uint64_t collides_with_bits = ~uint64_t{0});

  /// Where each ray enters every geometry in `collides_with_bits` that it hits, in order of fraction, then id.
  Result<std::vector<std::vector<RayEntry>>> CastRaysThrough(std::span<const Ray> rays,
                                                             uint64_t collides_with_bits = ~uint64_t{0});

  /// The first geometry that the bounded convex `shape` meets from each of `poses` along its translation, without
  /// turning. What it overlaps at the start is met at the fraction 0.
  Result<std::vector<ShapeCastHit>> CastShape(const Shape& shape, std::span<const Pose> poses,
                                              std::span<const Vector3> translations,
                                              uint64_t collides_with_bits = ~uint64_t{0});

  /// The geometries that the bounded convex `shape` overlaps at each of `poses`, ascending.
  Result<std::vector<std::vector<GeometryId>>> FindOverlaps(const Shape& shape, std::span<const Pose> poses,
                                                            uint64_t collides_with_bits = ~uint64_t{0});

  /// The geometry nearest to the bounded convex `shape` at each of `poses`, up to `distance_max` (m) away.
  Result<std::vector<ClosestPoints>> FindClosest(const Shape& shape, std::span<const Pose> poses, double distance_max,
                                                 uint64_t collides_with_bits = ~uint64_t{0});

  /// The distance of each pair of entities, over all of their geometries, sensors too, whatever their filters. A null
  /// `hit` if one of them has no geometry.
  Result<std::vector<ClosestPoints>> MeasureDistances(std::span<const EntityId> from,
                                                      std::span<const EntityId> to) const;

  /// Whom `id` touches as of the last step, ascending, with the points and impulses of its last substep; of sleepers
  /// the points where they lie.
  Result<std::vector<EntityContact>> ContactsOf(EntityId id) const;

  /// Hash of description, columns, layer state and the engine's private state: equal after a step, equal futures.
  uint64_t StateHash() const;

  /// With how much a step may begin; within it there may be a quarter more. Only tests have a reason to set it.
  void set_budget(const ContactBudget& budget) { budget_ = budget; }

  /// Steps fill `stats` only while this is on.
  void set_record_stats(bool on) { record_stats_ = on; }
  const StepStats& stats() const { return stats_; }

 private:
  friend class CommandValidator;  // reads the registry
  friend class StepRun;           // one step, as long as it runs
  friend class StepUndo;          // takes it back

  World(const BackendRegistry& registry, const WorldDesc& desc);

  // Commands, one each (world_apply.cc).
  EntityId Create(std::shared_ptr<const EntityDesc> desc, const MassProperties& mass);
  void Update(const UpdateEntity& command, std::shared_ptr<const EntityDesc> desc, const MassProperties& mass);
  void Delete(EntityId id);
  void Push(const ApplyForce& command);
  void ForgetSample(EntityId id);
  void Kick(const ApplyImpulse& command);
  void SetVelocityNow(const SetVelocity& command);
  void SetPoseNow(const SetPose& command);
  void SetOut(const SetPose& command);
  bool IsOnItsWay(EntityId id) const;
  bool EndPassage(EntityId id);
  void Halt(EntityId id);
  void DropLockedOf(EntityRow row);
  std::vector<CreatedId> ApplyAll(std::span<const Command> commands, std::vector<PreparedEntity>& prepared);
  void MakeDueEngine();
  void ApplyOne(const Command& command);
  void Grow();
  void AttachBody(EntityRow row);
  void DetachBody(EntityRow row);
  void Revive(EntityRow row);
  void IgnoreOthers(const SceneEntity& entity, bool ignores);

  // What commands leave to be done once for all of them (world_aftermath.cc).
  void Unforce(EntityId id);
  void SettleAftermath();
  void EndTouches();
  void DropForces();
  void DropSamples();
  void WakeStirred();
  void DropSolved();
  void RecordEnd(const TouchingPair& touching);

  // Force fields (world_fields.cc).
  EntityId CreateField(const CreateForceField& command, std::span<const CreatedId> created);
  void UpdateField(const UpdateForceField& command);
  void DeleteField(ForceFieldId id);
  void SetField(ForceFieldId id, ForceField field);
  void EndFieldsOfDeleted();
  void Disturb(const ForceField& field);
  void DisturbAll(std::span<const EntityId> ids);
  void WakeSprung();

  // Joints (world_joints.cc).
  JointId Join(JointDesc joint);
  void Rejoin(const UpdateJoint& command);
  void Unjoin(JointId id);
  void UnjoinAndTell(JointId id);
  void UnjoinAllOf(EntityId id);
  JointBroke Break(JointId id);
  void Drive(const SetMotorColumns& command);
  Pose PoseOf(const EntityRef& entity) const;
  void PlaceFrames(JointDesc& joint) const;
  void SetTouchable(const JointDesc& joint, bool touchable);
  void WakeJoined(const JointDesc& joint);
  void UnsettleJoined(const JointDesc& joint);
  void RestartJoined(const JointDesc& joint);
  void RestartDriven(const JointDesc& joint);
  void DrawJoined(const JointDesc& joint);
  void DriveOtherwise(JointId id, const JointDesc& joint, const JointKind& kind);
  void LeaveFrames(JointId id, const JointDesc& joint);
  void NoteDrive(JointId id, uint8_t place, const JointAxis& before);

  // Engine and activity (world.cc).
  // Without a start from the last solve unless `recalls`.
  void RebuildEngine(bool recalls = true);
  std::vector<EntityRow> RowsOfBodies() const;
  void AddToEngine(EntityRow row);
  void TellPose(EntityRow row);
  bool ShouldBeActive(EntityRow row) const;
  void UpdateActive(EntityRow row);
  void SetActive(EntityRow row, bool is_active);
  void Wake(EntityRow row);
  void WakeIslandOf(EntityRow row);
  void Unsettle(EntityRow row);
  void UnsettleAndWake(EntityRow row);
  void LetGo(EntityRow row);
  void WakeNeighboursOf(EntityRow row);
  void WakeWhereItIs(EntityRow row);
  void GatherSleepers();
  void WakeAll();
  void StirLying();
  void LayLying();
  void Record(EventKind kind);
  void FinishEvents(size_t first);
  Status Diverged(std::string_view why);
  Status OverBudget(std::string_view why, bool is_engine_new) const;
  Status Undone(const Status& why, bool is_engine_new) const;

  // Queries (world_queries.cc).
  Status CheckQuery(Feature feature) const;
  Status CheckShapeQuery(const Shape& shape, std::span<const Pose> poses) const;
  std::vector<GeometryRow> RowsIn(const Bounds& bounds, uint64_t collides_with_bits);
  std::pair<const Geometry*, Placement> Placed(GeometryRow row) const;
  ClosestPoints ClosestTo(const Shape& shape, const Placement& placement, double distance_max,
                          uint64_t collides_with_bits);
  RayHit CastRay(const Ray& ray, uint64_t collides_with_bits) const;
  std::vector<EventContactPoint> SolvedPointsOf(const ContactPair& pair) const;
  void AddSolvedPoints(const EntityPair& entities, std::vector<EventContactPoint>& points) const;
  void AddLastPoints(const EntityPair& entities, std::vector<EventContactPoint>& points) const;
  void RememberTouches(std::span<const EntityRow> sleepers);
  void AddLyingPoints(const EntityPair& entities, std::vector<EventContactPoint>& points) const;

  const BackendRegistry& registry_;
  Scene scene_;
  StateArrays state_;
  LayerState layer_;
  ContactBuffer contacts_;
  ContactBuffer solved_;  // what the last solve left: the next one, and another engine, go on from it
  PairRule rule_;
  std::vector<GeometryRows> geometry_rows_;  // by entity row
  const Backend* backend_ = nullptr;
  std::unique_ptr<BackendWorld> engine_;
  std::unique_ptr<NearPairs> near_;  // of what the engine has; null without one
  std::vector<double> reaches_;      // m, from the centre of mass to the farthest point; by entity row
  std::vector<uint8_t> flown_;       // moved by the layer alone, so that the engine has it elsewhere; by entity row
  // Whom the engine moves or tests against others: follows from columns and layer state.
  RowSet active_, lately_active_;
  std::vector<EntityId> woken_;    // not told yet
  std::vector<EntityRow> roused_;  // since the step began
  RowMarks sleepers_found_;        // scratch of who looks for those that wake
  struct Aftermath {
    std::vector<EntityRow> stirred;         // They wake, and their islands with them.
    std::vector<EntityId> displaced;        // They left where they were: whoever touched them there is let go of.
    std::vector<EntityId> detached;         // Bodies taken off: their pairs in solved_ are dropped.
    std::vector<EntityId> reshaped;         // They have other surfaces now: whatever touched them touches no more.
    std::vector<EntityId> pushed;           // They move or lie otherwise: both ends of springs at them wake.
    std::vector<EntityId> deleted;          // Force fields act on them no more.
    std::map<EntityId, size_t> forceless;   // Among the first so many pending forces theirs are dropped.
    std::vector<EntityId> unsampled;        // What is left of their sampled forces is dropped.
    size_t looks = 0;                       // At neighbours, one by one, to see whether they sleep.
    std::shared_ptr<SleeperTree> sleepers;  // All who sleep. Made when looking one by one has become dear.
    bool is_engine_due = false;             // Another engine was chosen, and is made when the batch is done.
  };
  Aftermath aftermath_;
  RowSet stirred_;              // of whom LayerState::lying may tell, though they are active
  bool is_stirred_ = false;     // whether there are any
  bool contacts_stale_ = true;  // something moved, came or changed since the last Collide()
  uint64_t changes_ = 0;
  // Who was put elsewhere, moves otherwise, touches or hangs on others, or woke since the last step but by it, or was
  // not done with then: what that makes meet or let go of each other, the next step finds at its start.
  RowMarks unsettled_;
  RowMarks let_go_;                // of these, whom something held or touched that went
  bool is_all_unsettled_ = false;  // another engine may see other contacts
  bool faulted_ = false, record_stats_ = false;
  uint32_t entity_count_ = 0, joint_count_ = 0, active_count_ = 0;
  StepStats stats_;
  std::vector<Event> events_;
  JointIndex joint_index_;
  std::unique_ptr<JointStep> joint_step_;
  struct Initial;
  ContactBudget budget_;
  StepUndo* undo_ = nullptr;  // of the step under way
  std::unique_ptr<StepScratch> scratch_;
  std::unique_ptr<Initial> initial_;  // as of the beginning
};

}  // namespace genphys

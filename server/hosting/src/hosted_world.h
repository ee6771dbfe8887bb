#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "genphys/hosting/event_log.h"
#include "genphys/hosting/frame_hub.h"
#include "genphys/hosting/keyframes.h"
#include "genphys/hosting/pace.h"
#include "genphys/hosting/stamp.h"
#include "genphys/status.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"
#include "genphys/world.h"
#include "step_requests.h"
#include "world_summary.h"

namespace genphys {

/// A world and what is told about it: one method per request, and the state between requests. Used by one thread at a
/// time. Requests have been checked against their declared limits.
class HostedWorld {
 public:
  /// The world that `wanted` asks for. `registry` and `pool` outlive it. `call_current` is FrameHub's.
  static Result<std::unique_ptr<HostedWorld>> Create(const BackendRegistry& registry, WorkerPool& pool,
                                                     const std::string& name, const v1::World& wanted,
                                                     std::string_view default_engine,
                                                     std::function<void()> call_current);

  Result<v1::CreateEntityResponse> CreateEntity(const v1::CreateEntityRequest& request);
  Result<v1::DeleteEntityResponse> DeleteEntity(const v1::DeleteEntityRequest& request);
  Result<v1::ApplyForceResponse> ApplyForce(const v1::ApplyForceRequest& request);
  Result<v1::GetEntityResponse> GetEntity(const v1::GetEntityRequest& request);
  Result<v1::ListEntitiesResponse> ListEntities(const v1::ListEntitiesRequest& request);
  Result<v1::ListForceFieldsResponse> ListForceFields(const v1::ListForceFieldsRequest& request);
  Result<v1::ListJointsResponse> ListJoints(const v1::ListJointsRequest& request);
  Result<v1::CastRaysResponse> CastRays(const v1::CastRaysRequest& request);
  Result<v1::CastShapeResponse> CastShape(const v1::CastShapeRequest& request);
  Result<v1::FindOverlapsResponse> FindOverlaps(const v1::FindOverlapsRequest& request);
  Result<v1::FindClosestResponse> FindClosest(const v1::FindClosestRequest& request);
  Result<v1::MeasureDistancesResponse> MeasureDistances(const v1::MeasureDistancesRequest& request);
  Result<v1::GetContactsResponse> GetContacts(const v1::GetContactsRequest& request);
  Result<v1::GetWorldResponse> GetWorld(const v1::GetWorldRequest& request);
  Result<v1::ResetWorldResponse> ResetWorld(const v1::ResetWorldRequest& request);
  Result<v1::PlayWorldResponse> PlayWorld(const v1::PlayWorldRequest& request);
  Result<v1::PauseWorldResponse> PauseWorld(const v1::PauseWorldRequest& request);

  // The parts of a Step call; see StepCall.

  /// Applies all of `commands` or none.
  Result<std::vector<CreatedId>> Apply(std::span<const Command> commands);
  /// WORLD_FAULTED, WORLD_NOT_PAUSED or OK.
  Status CheckSteppable() const;
  /// Before the first step: what comes along with that is not of the beginning, to which a reset goes back, unless no
  /// step came of it.
  void MarkBeginning();
  void ForgetBeginning();
  Status Step(std::optional<double> step_size);
  /// Logs what happened since the last call, and returns it. Null: nothing did.
  std::shared_ptr<const EventChunk> PublishEvents();
  /// That, and a frame for those who watch: the world is at rest until the next request or step.
  std::shared_ptr<const EventChunk> Publish();

  /// Steps as the pace says until `slice_end`; when to be called again, or nothing if the world does not play. A world
  /// in which nothing moves and which nobody watches is left alone for long, so that others come to it by CatchUp().
  std::optional<Pace::Clock::time_point> Play(Pace::Clock::time_point slice_end);
  /// Takes the steps that were due while the world was left alone: to be called before anything asks of it.
  void CatchUp();
  /// True once after something came that ends the rest of a world that plays: then Play() is to be called at once.
  bool EndRest();
  /// Stops playing, if it does.
  void Stop() {
    pace_.reset();
    summary_.SetState(state());
  }

  /// An exception came out of the world: from now on it can only be read, reset and deleted.
  void Break(const Status& why);

  Stamp stamp();
  World& world() { return *world_; }
  const std::shared_ptr<EventLog>& events() const { return events_; }
  const std::shared_ptr<FrameHub>& frames() const { return frames_; }
  Keyframes& keyframes() { return keyframes_; }
  StepRequests& step_requests() { return step_requests_; }
  /// For every thread at any time: true of the world after its last whole change.
  const WorldSummary& summary() const { return summary_; }

 private:
  HostedWorld(WorkerPool& pool, std::string name, std::unique_ptr<World> world, bool record_state_hash,
              std::function<void()> call_current);

  bool faulted() const { return broken_ || world_->faulted(); }
  v1::World::State state() const;
  void UpdateSummary();
  Status CheckUsable() const;
  // Whether it can be said where its geometries are.
  Status CheckReadable() const;
  // After which id a page of `list` begins.
  Result<uint64_t> PlaceIn(char list, const std::string& page_token) const;
  // One command; its refusals are told by paths that begin with `outer` in place of `inner`.
  Result<EntityId> ApplyOne(Command command, std::string_view inner, std::string_view outer);

  const std::string name_;
  const bool record_state_hash_;
  std::unique_ptr<World> world_;
  uint64_t epoch_ = NewEpoch();
  bool broken_ = false;
  bool has_beginning_ = false;
  std::optional<uint64_t> state_hash_;  // of the present, once it was asked for
  std::optional<Pace> pace_;            // set: it plays
  std::optional<uint64_t> rests_at_;    // set: it is left alone; World::changes() then
  std::shared_ptr<EventLog> events_;
  std::shared_ptr<FrameHub> frames_;
  Keyframes keyframes_;
  StepRequests step_requests_;
  WorldSummary summary_;
};

}  // namespace genphys

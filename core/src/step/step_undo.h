#pragma once
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "genphys/world.h"

namespace genphys {

/// What a step has to remember of a world to leave it as it was. It costs by what the step changes, so that steps that
/// touch few of many entities do not pay for all of them. What a step changes after it found contacts for the last time
/// is not remembered: nothing fails from there on.
class StepUndo {
 public:
  /// Of the row as it was; the earliest of one row counts.
  struct Row {
    EntityRow row{};
    Pose pose;
    Vector3 linear_velocity = Vector3::Zero();
    Vector3 angular_velocity = Vector3::Zero();
    bool asleep = false;
    bool faulted = false;
    double rest_time = 0;
    HalfStep half;
  };

  /// For as long as it lives, the world remembers here what wakes.
  explicit StepUndo(World& world);
  ~StepUndo() { world_.undo_ = nullptr; }
  StepUndo(const StepUndo&) = delete;
  StepUndo& operator=(const StepUndo&) = delete;

  /// To be called before any of these is changed.
  void Keep(EntityRow row);
  /// Of one that wakes.
  void KeepTouches(EntityRow row, std::vector<LastTouch> touches) { touches_.emplace_back(row, std::move(touches)); }
  void KeepPassages();
  void KeepForces();
  void KeepSolved();
  /// Those of the step before are about to be overwritten.
  void LoseContacts() { has_lost_contacts_ = true; }
  /// They may be found again by the next step, if they are lost: they are as they were then.
  void LeaveContactsToBeFound() { finds_contacts_ = false; }
  /// The engine is about to solve.
  void SpoilEngine() { is_engine_spoilt_ = true; }
  /// These came from LayerState::lying to LayerState::touching.
  void Stirred(std::span<const TouchingPair> pairs) { stirred_.insert(stirred_.end(), pairs.begin(), pairs.end()); }
  /// World::unsettled_ and World::let_go_ came to have these.
  void Unsettled(EntityRow row) { unsettled_.push_back(row); }
  void HasLetGo(EntityRow row) { let_go_.push_back(row); }
  void Reserve(size_t rows) { rows_.reserve(rows_.size() + rows); }

  /// Whether the engine has begun to solve in this step.
  bool is_engine_spoilt() const { return is_engine_spoilt_; }

  std::span<const Row> rows() const { return rows_; }

  /// Puts columns and layer back, but for joints, and tells the engine if there still is one. An engine that has solved
  /// in this step remembers that solve and not the one before, or is in the middle of it, so it is made anew, as if it
  /// had been changed.
  void Undo();

 private:
  void PutBack(const Row& saved);
  void LayStirred();
  void FindContacts();

  World& world_;
  std::vector<Row> rows_;
  std::vector<std::pair<EntityRow, std::vector<LastTouch>>> touches_;  // by row
  std::optional<std::map<EntityId, Passage>> passages_;
  std::optional<std::vector<PendingForce>> forces_;
  std::vector<TouchingPair> stirred_;
  std::vector<EntityRow> unsettled_;
  std::vector<EntityRow> let_go_;
  double last_substep_;
  bool has_solved_ = false;
  bool is_engine_spoilt_ = false;
  bool has_lost_contacts_ = false;
  bool finds_contacts_ = true;
  bool contacts_stale_;
  RowSet stirred_rows_;
};

}  // namespace genphys

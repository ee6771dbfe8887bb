#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "genphys/command.h"
#include "genphys/event.h"
#include "genphys/force_field.h"
#include "genphys/ids.h"
#include "genphys/joint.h"
#include "genphys/pair_set.h"

namespace genphys {

/// Hands out ids: lowest free slot first, each tenant of a slot with a new generation. An exhausted slot is retired.
class IdAllocator {
 public:
  template <typename Tag>
  Id<Tag> Allocate() {
    const uint32_t slot = AllocateSlot();
    return Id<Tag>(slot, generations[slot]);
  }
  template <typename Tag>
  void Free(Id<Tag> id) {
    FreeSlot(id.index());
  }

  std::vector<uint32_t> generations;  // of the next or present tenant, by slot
  std::vector<uint32_t> free_slots;   // a heap with the lowest on top

 private:
  uint32_t AllocateSlot();
  void FreeSlot(uint32_t slot);
};

/// A force that still acts. `point` is in the frame of the entity; force and torque are as `coordinates` says.
struct PendingForce {
  EntityId id;
  Vector3 force = Vector3::Zero();
  Vector3 torque = Vector3::Zero();
  Vector3 point = Vector3::Zero();  // of attack, in the frame of the entity
  bool at_center_of_mass = true;
  Coordinates coordinates = Coordinates::kWorld;
  uint32_t steps_left = 1;
  bool is_sampled = false;
};

/// All sampled forces on an entity in the last step, world coordinates, about its centre of mass.
struct SampledForce {
  EntityId id;
  Vector3 force = Vector3::Zero();   // N
  Vector3 torque = Vector3::Zero();  // N*m
};

/// What drove a coordinate of a joint until it was told otherwise, since the last step.
struct FormerDrive {
  JointId id;
  uint8_t place = 0;  // as kJointCoordinates lists them
  std::optional<Motor> motor;
  std::optional<Spring> spring;
};

/// Where the frames of a joint were that locks nothing there, likewise.
struct FormerFrames {
  JointId id;
  Pose in_a;
  Pose in_b;
};

/// How somebody who fell asleep was held by another entity at its last solve.
struct LastTouch {
  EntityId other;
  std::vector<EventContactPoint> points;  // from the smaller id to the larger
};

/// The way of a kinematic entity to a pose.
struct Passage {
  Pose target;
  uint32_t steps_left = 0;  // zero: it is there and has still to be stopped
};

/// Of its turning, a body that joints hold may have so much more energy than what was done to it gave it: the part of
/// the most that it lately had. Steps that do not resolve how it turns give and take some.
inline constexpr double kUnearnedPart = 0.2;

/// What the leapfrog keeps of a moving body beside its columns, which show the true velocity at the step boundary. An
/// engine moves bodies with the velocity of the middle of a substep; the second half of what acted in it is still owed
/// to that velocity then. What acts from outside is paid when the next substep begins. What contacts and joints gave is
/// shown, but paid only when they let go: the solver finds it anew, and feeding it back would keep its noise alive.
struct HalfStep {
  /// So many substeps, the first one counted, are between two that pay what contacts and joints owe: paying it at every
  /// substep would let the solver's noise swing back and forth. It dies out in one that goes on from the last.
  static constexpr uint8_t kPause = 2;

  bool restarts = true;       // the next substep begins with the columns, and the rest means nothing
  bool in_flight = true;      // nothing held or hit it in the last substep
  bool has_past = false;      // `held_rate` means something
  uint8_t since_restart = 0;  // substeps, at most kPause
  bool is_struck = false;     // an impact changed its velocity since the last solve
  bool is_woken = false;      // it slept at the last solve
  bool is_drawn = false;      // what joints give it may be another thing than in the last solve
  bool is_mean = false;       // `held_rate` is the mean of what joints gave before a jump and give since, and not owed
  // In the middle of the last substep; of a kinematic body as told for the step that led it last.
  Vector3 velocity = Vector3::Zero();       // m/s, of the centre of mass
  Vector3 momentum = Vector3::Zero();       // angular, kg*m^2/s, world; of a kinematic body its spin, rad/s
  Vector3 steady_kick = Vector3::Zero();    // m/s still owed by gravity and by forces that stay as they are
  Vector3 steady_twist = Vector3::Zero();   // N*m*s, the same of torques
  Vector3 held_velocity = Vector3::Zero();  // m/s still owed by contacts and joints
  Vector3 held_momentum = Vector3::Zero();  // N*m*s
  Vector3 held_rate = Vector3::Zero();      // m/s^2, by contacts and joints in the last substep
  Vector3 held_torque = Vector3::Zero();    // N*m, the same
  double peak = 0;                          // J, of its turning while joints hold it: the most that it lately had
  double unearned = 0;                      // J, of that: what it got beyond what was done to it
  double substep = 0;                       // s, the last one that it took part in: what is owed is for half of it
  uint64_t last_led = 0;                    // of a kinematic body: the step that led it last, the first one being 1

  /// For how long (s) a solve acts on the velocity: from the middle of the last substep, of `last` seconds, to the
  /// middle of the next one, of `h` seconds.
  double Interval(double last, double h) const { return restarts ? h / 2 : (last + h) / 2; }
  /// From now on the columns say all, as after a change from outside.
  void Restart() { restarts = true; }
  /// The same after what may come again in every step.
  void RestartNowAndThen() { restarts |= !Pauses(); }
  bool Pauses() const { return since_restart < kPause; }
  /// It has come to rest, and was shown with a velocity and angular momentum that are no more than what is left of a
  /// motion: what acts on it from outside is held as it was.
  void Rest(const Vector3& shown_velocity, const Vector3& shown_momentum) {
    held_velocity += velocity - shown_velocity;
    held_momentum += momentum - shown_momentum;
    velocity.setZero();
    momentum.setZero();
  }
  /// As before the first substep.
  void Forget() { *this = HalfStep{}; }
};

/// How a velocity changed since somebody began to look.
struct Drift {
  Vector3 first = Vector3::Zero();
  Vector3 last = Vector3::Zero();
  double changes = 0;  // the sum of all

  void Begin(const Vector3& velocity) { *this = {velocity, velocity, 0}; }
  void Look(const Vector3& velocity) {
    changes += (velocity - last).norm();
    last = velocity;
  }
  /// By more than `least`, and mostly in one direction: not as what trembles.
  bool IsSteady(double least) const {
    constexpr double kMostly = 0.9;
    const double all = (last - first).norm();
    return all > least && all > kMostly * changes;
  }
};

/// From where an entity at rest is watched that it stays there, and is not on its way.
struct RestWatch {
  double time = 0;  // s since it was there
  Pose from;
  Drift linear;   // m/s
  Drift angular;  // rad/s
};

/// All that the future depends on besides the description and the columns. Fields are written by Serialize() alone;
/// one that it forgets does not compile.
struct LayerState {
  uint64_t step = 0;           // steps taken
  double simulation_time = 0;  // s, sum of the step sizes taken
  uint64_t next_event_sequence = 1;
  ForceFieldId next_force_field = 1;
  IdAllocator ids;
  std::vector<double> rest_times;       // s at rest so far, by row
  std::vector<RestWatch> rest_watches;  // of who rests, by row
  std::vector<uint8_t> moving;          // bit 0: in translation, bit 1: in rotation, as last told; by row
  std::vector<uint8_t> faulted;         // left the bounds and was disabled, by row
  // Pairs of which somebody is active are in the first, ascending, so that the second one costs nothing.
  std::vector<TouchingPair> touching;
  PairSet lying;
  std::vector<PendingForce> forces;  // in order of command
  std::map<EntityId, Passage> passages;
  IdAllocator joint_ids;
  std::vector<JointState> joints;                    // by slot of the joint's id: what it held, and its full turns
  std::vector<FormerDrive> former_drives;            // in order of command: the first of a coordinate counts
  std::vector<FormerFrames> former_frames;           // the same of each joint
  std::vector<std::vector<LastTouch>> last_touches;  // by row, of sleepers and until their next solve
  std::vector<HalfStep> half_steps;                  // by row
  double last_substep = 0;                           // s
  double last_step = 0;                              // s, the last step in which somebody was awake or driven
  std::vector<SampledForce> samples;                 // ascending
  double samples_step = 0;                           // s, of the step that they were for; zero without any
};

/// Appends every field of `state` to `bytes`, little-endian.
void Serialize(const LayerState& state, std::string& bytes);

}  // namespace genphys

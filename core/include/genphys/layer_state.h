#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "genphys/command.h"
#include "genphys/event.h"
#include "genphys/force_field.h"
#include "genphys/ids.h"
#include "genphys/joint.h"

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
};

/// Two entities that touch, or a sensor and its visitor.
struct TouchingPair {
  EntityPair pair;
  bool is_sensor = false;
  bool a_is_sensor = false;  // which of the two carries the sensor
  auto operator<=>(const TouchingPair&) const = default;
};

/// How somebody who fell asleep was held by another entity at its last solve.
struct LastTouch {
  EntityId other;
  std::vector<EventContactPoint> points;  // from the smaller id to the larger
};

/// All that the future depends on besides the description and the columns. Fields are written by Serialize() alone;
/// one that it forgets does not compile.
struct LayerState {
  uint64_t step = 0;           // steps taken
  double simulation_time = 0;  // s, sum of the step sizes taken
  uint64_t next_event_sequence = 1;
  ForceFieldId next_force_field = 1;
  IdAllocator ids;
  std::vector<double> rest_times;      // s at rest so far, by row
  std::vector<uint8_t> moving;         // bit 0: in translation, bit 1: in rotation, as last told; by row
  std::vector<uint8_t> faulted;        // left the bounds and was disabled, by row
  std::vector<TouchingPair> touching;  // ascending
  std::vector<PendingForce> forces;    // in order of command
  IdAllocator joint_ids;
  std::vector<JointState> joints;                    // by slot of the joint's id
  std::vector<std::vector<LastTouch>> last_touches;  // of sleepers, by row
};

/// Appends every field of `state` to `bytes`, little-endian.
void Serialize(const LayerState& state, std::string& bytes);

}  // namespace genphys

#include "genphys/layer_state.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "model/serialize.h"

namespace genphys {

uint32_t IdAllocator::AllocateSlot() {
  if (free_slots.empty()) {
    generations.push_back(0);
    return static_cast<uint32_t>(generations.size()) - 1;
  }
  std::pop_heap(free_slots.begin(), free_slots.end(), std::greater<>());
  const uint32_t slot = free_slots.back();
  free_slots.pop_back();
  return slot;
}

void IdAllocator::FreeSlot(uint32_t slot) {
  // The last generation is never handed out, so that a stale id stays tellable from one of the future.
  if (++generations[slot] == std::numeric_limits<uint32_t>::max()) return;
  free_slots.push_back(slot);
  std::push_heap(free_slots.begin(), free_slots.end(), std::greater<>());
}

namespace {

void Put(ByteWriter& out, const EntityPair& value) {
  const auto& [a, b] = value;
  out.Put(a.packed());
  out.Put(b.packed());
}

void Put(ByteWriter& out, const TouchingPair& value) {
  const auto& [pair, is_sensor, a_is_sensor] = value;
  Put(out, pair);
  out.Put(is_sensor);
  out.Put(a_is_sensor);
}

void Put(ByteWriter& out, const Drift& value) {
  const auto& [first, last, changes] = value;
  out.Put(first);
  out.Put(last);
  out.Put(changes);
}

void Put(ByteWriter& out, const RestWatch& value) {
  const auto& [time, from, linear, angular] = value;
  out.Put(time);
  out.Put(from.position);
  out.Put(from.orientation);
  Put(out, linear);
  Put(out, angular);
}

void Put(ByteWriter& out, const PendingForce& value) {
  const auto& [id, force, torque, point, at_center_of_mass, coordinates, steps_left, is_sampled] = value;
  out.Put(id.packed());
  out.Put(force);
  out.Put(torque);
  out.Put(point);
  out.Put(at_center_of_mass);
  out.Put(static_cast<uint8_t>(coordinates));
  out.Put(steps_left);
  out.Put(is_sampled);
}

void Put(ByteWriter& out, const SampledForce& value) {
  const auto& [id, force, torque] = value;
  out.Put(id.packed());
  out.Put(force);
  out.Put(torque);
}

void Put(ByteWriter& out, const Passage& value) {
  const auto& [target, steps_left] = value;
  out.Put(target.position);
  out.Put(target.orientation);
  out.Put(steps_left);
}

void Put(ByteWriter& out, const IdAllocator& ids) {
  out.PutColumn(ids.generations);
  out.PutColumn(ids.free_slots);
}

void Put(ByteWriter& out, const JointState& value) {
  const auto& [positions, rates, force, torque, haste] = value;
  for (double position : positions) out.Put(position);
  for (double rate : rates) out.Put(rate);
  out.Put(force);
  out.Put(torque);
  out.Put(haste);
}

void Put(ByteWriter& out, const std::optional<double>& value) {
  out.Put(value.has_value());
  out.Put(value.value_or(0));
}

void Put(ByteWriter& out, const FormerDrive& value) {
  const auto& [id, place, motor, spring] = value;
  out.Put(id.packed());
  out.Put(place);
  out.Put(motor.has_value());
  if (motor) {
    const auto& [target_velocity, target_position, stiffness, damping, force_max] = *motor;
    Put(out, target_position);
    Put(out, force_max);
    for (const double number : {target_velocity, stiffness, damping}) out.Put(number);
  }
  out.Put(spring.has_value());
  if (!spring) return;
  const auto& [stiffness, damping, rest] = *spring;
  for (const double number : {stiffness, damping, rest}) out.Put(number);
}

void Put(ByteWriter& out, const FormerFrames& value) {
  const auto& [id, in_a, in_b] = value;
  out.Put(id.packed());
  for (const Pose& pose : {in_a, in_b}) {
    out.Put(pose.position);
    out.Put(pose.orientation);
  }
}

void Put(ByteWriter& out, const EventContactPoint& value) {
  const auto& [position, normal, depth, normal_impulse, friction_impulse, relative_velocity, friction, restitution,
               geometry_a, geometry_b] = value;
  for (const Vector3* vector : {&position, &normal, &friction_impulse, &relative_velocity}) out.Put(*vector);
  for (const double number : {depth, normal_impulse, friction, restitution}) out.Put(number);
  out.Put(geometry_a);
  out.Put(geometry_b);
}

void Put(ByteWriter& out, const LastTouch& value) {
  const auto& [other, points] = value;
  out.Put(other.packed());
  out.Put(uint64_t{points.size()});
  for (const EventContactPoint& point : points) Put(out, point);
}

void Put(ByteWriter& out, const HalfStep& value) {
  const auto& [restarts, in_flight, has_past, since_restart, is_struck, is_woken, is_drawn, is_mean, velocity, momentum,
               steady_kick, steady_twist, held_velocity, held_momentum, held_rate, held_torque, peak, unearned, substep,
               last_led] = value;
  out.Put(restarts);
  out.Put(in_flight);
  out.Put(has_past);
  out.Put(since_restart);
  out.Put(is_struck);
  out.Put(is_woken);
  out.Put(is_drawn);
  out.Put(is_mean);
  for (const Vector3* v :
       {&velocity, &momentum, &steady_kick, &steady_twist, &held_velocity, &held_momentum, &held_rate, &held_torque})
    out.Put(*v);
  out.Put(peak);
  out.Put(unearned);
  out.Put(substep);
  out.Put(last_led);
}

}  // namespace

void Serialize(const LayerState& state, std::string& bytes) {
  // Structured bindings name every field: one more in the struct does not compile until it is written here too.
  const auto& [step, simulation_time, next_event_sequence, next_force_field, ids, rest_times, rest_watches, moving,
               faulted, touching, lying, forces, passages, joint_ids, joints, former_drives, former_frames,
               last_touches, half_steps, last_substep, last_step, samples, samples_step] = state;
  ByteWriter out(bytes);
  out.Put(step);
  out.Put(simulation_time);
  out.Put(next_event_sequence);
  Put(out, ids);
  out.Put(next_force_field);
  out.PutColumn(rest_times);
  for (const RestWatch& watch : rest_watches) Put(out, watch);
  out.PutColumn(moving);
  out.PutColumn(faulted);
  out.Put(uint64_t{touching.size()});
  for (const TouchingPair& pair : touching) Put(out, pair);
  out.Put(uint64_t{lying.size()});
  for (const TouchingPair& pair : lying.Sorted()) Put(out, pair);
  out.Put(uint64_t{forces.size()});
  for (const PendingForce& force : forces) Put(out, force);
  out.Put(uint64_t{passages.size()});
  for (const auto& [id, passage] : passages) {
    out.Put(id.packed());
    Put(out, passage);
  }
  Put(out, joint_ids);
  out.Put(uint64_t{joints.size()});
  for (const JointState& joint : joints) Put(out, joint);
  out.Put(uint64_t{former_drives.size()});
  for (const FormerDrive& drive : former_drives) Put(out, drive);
  out.Put(uint64_t{former_frames.size()});
  for (const FormerFrames& frames : former_frames) Put(out, frames);
  out.Put(uint64_t{last_touches.size()});
  for (const std::vector<LastTouch>& touches : last_touches) {
    out.Put(uint64_t{touches.size()});
    for (const LastTouch& touch : touches) Put(out, touch);
  }
  out.Put(uint64_t{half_steps.size()});
  for (const HalfStep& half : half_steps) Put(out, half);
  out.Put(last_substep);
  out.Put(last_step);
  out.Put(uint64_t{samples.size()});
  for (const SampledForce& sample : samples) Put(out, sample);
  out.Put(samples_step);
}

}  // namespace genphys

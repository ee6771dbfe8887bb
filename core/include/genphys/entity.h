#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "genphys/error_correction.h"
#include "genphys/ids.h"
#include "genphys/material.h"
#include "genphys/math.h"
#include "genphys/shape.h"

namespace genphys {

enum class MotionType : uint8_t {
  kStatic,     // never moves; infinite mass
  kKinematic,  // moves as told by its velocity and pushes others; infinite mass
  kDynamic,    // moves by forces
};

/// One collision geometry of an entity.
struct Geometry {
  uint32_t id = 0;  // unique in its entity; zero in a command: the scene assigns one
  Shape shape;
  Pose pose_in_entity;
  Material material;
  uint64_t category_bits = 1;
  uint64_t collides_with_bits = ~uint64_t{0};
  bool is_sensor = false;                      // reports overlaps, pushes nothing
  std::string collision_space;                 // members of one space never collide; "car/wheels" is inside "car"
  Vector3 surface_velocity = Vector3::Zero();  // m/s, in its own frame: its surface runs over it like a belt
  bool operator==(const Geometry&) const = default;
};

/// Mass properties as asked for. Unset: from shapes and densities. Mass alone: the shapes' tensor scaled to it.
struct InertiaDesc {
  std::optional<double> mass;             // kg
  std::optional<Vector3> center_of_mass;  // in the frame of the entity, m
  std::optional<Matrix3> tensor;          // kg*m^2 about the centre of mass, axes of the entity's frame
};

/// When a resting entity may be put to sleep. Unset fields take the world's defaults.
struct AutoDisable {
  std::optional<bool> enabled;              // default true
  std::optional<double> linear_speed_max;   // m/s, default 0.02
  std::optional<double> angular_speed_max;  // rad/s, default 0.05
  std::optional<double> rest_time;          // s, default 0.5
  bool operator==(const AutoDisable&) const = default;
};

AutoDisable Filled(const AutoDisable& policy, const AutoDisable& defaults);

/// Axes of the world along which the centre of mass of a dynamic body does not move, and about which it does not turn.
struct LockedAxes {
  std::array<bool, 3> linear{};   // x, y, z
  std::array<bool, 3> angular{};  // x, y, z
  bool any() const { return *this != LockedAxes{}; }
  bool operator==(const LockedAxes&) const = default;
};

/// The physics of an entity. Velocities are the initial ones, in world coordinates.
struct RigidBody {
  MotionType motion_type = MotionType::kDynamic;
  std::vector<Geometry> geometries;
  InertiaDesc inertia;
  AutoDisable auto_disable;
  ErrorCorrection error_correction;
  Vector3 linear_velocity = Vector3::Zero();   // of the centre of mass, m/s
  Vector3 angular_velocity = Vector3::Zero();  // rad/s
  double linear_damping = 0;                   // 1/s: velocity decays as exp(-c t)
  double angular_damping = 0;                  // 1/s
  double gravity_scale = 1;                    // part of the world's gravity that acts on it
  std::optional<double> linear_speed_max;      // m/s, of the centre of mass; faster is slowed down at every step
  std::optional<double> angular_speed_max;     // rad/s, likewise
  LockedAxes locked_axes;                      // of a dynamic body
  std::vector<EntityId> ignored_entities;      // it and they never touch; whom only they name counts as well
};

/// What a renderer should draw; carried along, never looked into.
struct Visual {
  std::string uri;
  std::string media_type;
  std::string data;
  bool operator==(const Visual&) const = default;
};

/// What was asked for. Without `rigid_body` the entity stays where it is put and collides with nothing.
struct EntityDesc {
  std::string display_name;
  Pose pose;  // of the entity's frame in the world
  std::optional<RigidBody> rigid_body;
  std::optional<Visual> visual;
};

inline bool IsDynamic(const EntityDesc& desc) {
  return desc.rigid_body && desc.rigid_body->motion_type == MotionType::kDynamic;
}

}  // namespace genphys

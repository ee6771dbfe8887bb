#include "model/state_hash.h"

#include <xxhash.h>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"
#include "model/serialize.h"

namespace genphys {
namespace {

// Structured bindings throughout: a new field of a description does not compile until it is part of the hash.

void Put(ByteWriter& out, const Sphere& shape) {
  const auto& [radius] = shape;
  out.Put(radius);
}
void Put(ByteWriter& out, const Box& shape) {
  const auto& [half_extents] = shape;
  out.Put(half_extents);
}
void Put(ByteWriter& out, const Capsule& shape) {
  const auto& [radius, half_length] = shape;
  out.Put(radius);
  out.Put(half_length);
}
void Put(ByteWriter& out, const Cylinder& shape) {
  const auto& [radius, half_length] = shape;
  out.Put(radius);
  out.Put(half_length);
}
void Put(ByteWriter& out, const Plane& shape) {
  const auto& [normal, offset] = shape;
  out.Put(normal);
  out.Put(offset);
}

void Put(ByteWriter& out, const Cone& shape) {
  const auto& [radius, half_length] = shape;
  out.Put(radius);
  out.Put(half_length);
}
void Put(ByteWriter& out, const Ellipsoid& shape) {
  const auto& [semi_axes] = shape;
  out.Put(semi_axes);
}
// Of large shapes the hash of what was asked for, from which the rest follows, was made with them.
void Put(ByteWriter& out, const ConvexHull& shape) {
  const auto& [data] = shape;
  out.Put(uint64_t{data->points.size()});
  out.Put(data->hash);
}
void Put(ByteWriter& out, const TriangleMesh& shape) {
  const auto& [data] = shape;
  out.Put(uint64_t{data->indices.size()});
  out.Put(data->hash);
}
void Put(ByteWriter& out, const Heightfield& shape) {
  const auto& [data] = shape;
  out.Put(data->rows);
  out.Put(data->hash);
}

void Put(ByteWriter& out, const Pose& pose) {
  const auto& [position, orientation] = pose;
  out.Put(position);
  out.Put(orientation);
}

void Put(ByteWriter& out, const Material& material) {
  const auto& [friction, kinetic_friction, restitution, density, friction_mixing, restitution_mixing, rolling_friction,
               spinning_friction] = material;
  out.Put(friction);
  out.Put(kinetic_friction);
  out.Put(restitution);
  out.Put(density);
  for (const std::optional<Mixing>& rule : {friction_mixing, restitution_mixing}) {
    out.Put(static_cast<uint8_t>(rule ? static_cast<int>(*rule) + 1 : 0));
  }
  out.Put(rolling_friction);
  out.Put(spinning_friction);
}

void Put(ByteWriter& out, const AutoDisable& policy) {
  const auto& [enabled, linear_speed_max, angular_speed_max, rest_time] = policy;
  out.Put(enabled);
  out.Put(linear_speed_max);
  out.Put(angular_speed_max);
  out.Put(rest_time);
}

void Put(ByteWriter& out, const ErrorCorrection& correction) {
  const auto& [time_constant, speed_max, slop] = correction;
  for (const std::optional<double>& field : {time_constant, speed_max, slop}) out.Put(field);
}

void Put(ByteWriter& out, const Geometry& geometry) {
  const auto& [id, shape, pose, material, category_bits, collides_with_bits, is_sensor, collision_space,
               surface_velocity] = geometry;
  out.Put(id);
  out.Put(uint8_t(shape.index()));
  std::visit([&](const auto& form) { Put(out, form); }, shape);
  Put(out, pose);
  Put(out, material);
  out.Put(category_bits);
  out.Put(collides_with_bits);
  out.Put(is_sensor);
  out.Put(std::string_view(collision_space));
  out.Put(surface_velocity);
}

void Put(ByteWriter& out, const RigidBody& body) {
  const auto& [motion_type, geometries, inertia, auto_disable, error_correction, linear_velocity, angular_velocity,
               linear_damping, angular_damping, gravity_scale, linear_speed_max, angular_speed_max, locked_axes,
               ignored_entities] = body;
  const auto& [mass, center_of_mass, tensor] = inertia;
  out.Put(static_cast<uint8_t>(motion_type));
  out.Put(uint64_t{geometries.size()});
  for (const Geometry& geometry : geometries) Put(out, geometry);
  out.Put(mass);
  out.Put(center_of_mass);
  out.Put(tensor);
  Put(out, auto_disable);
  Put(out, error_correction);
  out.Put(linear_velocity);
  out.Put(angular_velocity);
  out.Put(linear_damping);
  out.Put(angular_damping);
  out.Put(gravity_scale);
  out.Put(linear_speed_max);
  out.Put(angular_speed_max);
  const auto& [linear, angular] = locked_axes;
  for (const auto& axes : {linear, angular}) {
    for (const bool is_locked : axes) out.Put(is_locked);
  }
  out.Put(uint64_t{ignored_entities.size()});
  for (const EntityId id : ignored_entities) out.Put(id.packed());
}

void Put(ByteWriter& out, const EntityDesc& desc) {
  const auto& [display_name, pose, rigid_body, visual] = desc;
  out.Put(std::string_view(display_name));
  Put(out, pose);
  out.Put(rigid_body.has_value());
  if (rigid_body) Put(out, *rigid_body);
  out.Put(visual.has_value());
  if (visual) {
    const auto& [uri, media_type, data] = *visual;
    out.Put(std::string_view(uri));
    out.Put(std::string_view(media_type));
    out.Put(std::string_view(data));
  }
}

void Put(ByteWriter& out, const StepperDesc& stepper) {
  const auto& [step_size, quality, solver, substeps, iterations, engine_only] = stepper;
  out.Put(step_size);
  out.Put(static_cast<uint8_t>(quality));
  out.Put(static_cast<uint8_t>(solver));
  out.Put(substeps);
  out.Put(iterations);
  out.Put(engine_only);
}

void Put(ByteWriter& out, const EventKinds& kinds) {
  const auto& [contacts, persisting, points, sensors, sleeping, moving, joints, changes] = kinds;
  for (bool kind : {contacts, persisting, points, sensors, sleeping, moving, joints, changes}) out.Put(kind);
}

void Put(ByteWriter& out, const JointAxis& axis) {
  const auto& [limits, motor, spring] = axis;
  const auto& [lower, upper] = limits;
  out.Put(lower);
  out.Put(upper);
  out.Put(motor.has_value());
  if (motor) {
    const auto& [target_velocity, target_position, stiffness, damping, force_max] = *motor;
    out.Put(target_velocity);
    out.Put(target_position);
    out.Put(stiffness);
    out.Put(damping);
    out.Put(force_max);
  }
  out.Put(spring.has_value());
  if (spring) {
    const auto& [stiffness, damping, rest] = *spring;
    out.Put(stiffness);
    out.Put(damping);
    out.Put(rest);
  }
}

void Put(ByteWriter& out, const std::optional<JointAxis>& axis) {
  out.Put(axis.has_value());
  if (axis) Put(out, *axis);
}

struct JointWriter {
  ByteWriter& out;

  void operator()(const BallJoint& joint) const {
    const auto& [swing_max, twist] = joint;
    out.Put(swing_max);
    out.Put(twist.lower);
    out.Put(twist.upper);
  }
  void operator()(const HingeJoint& joint) const { Put(out, joint.axis); }
  void operator()(const SliderJoint& joint) const { Put(out, joint.axis); }
  void operator()(const UniversalJoint& joint) const {
    const auto& [about_x, about_y] = joint;
    Put(out, about_x);
    Put(out, about_y);
  }
  void operator()(const FixedJoint&) const {}
  void operator()(const WheelJoint& joint) const {
    const auto& [suspension, steering, spin] = joint;
    Put(out, suspension);
    Put(out, steering);
    Put(out, spin);
  }
  void operator()(const SixDofJoint& joint) const {
    const auto& [along, about] = joint;
    for (const auto& axis : along) Put(out, axis);
    for (const auto& axis : about) Put(out, axis);
  }
  void operator()(const DistanceJoint& joint) const { Put(out, joint.axis); }
  void operator()(const GearJoint& joint) const { out.Put(joint.ratio); }
};

void Put(ByteWriter& out, const JointDesc& desc) {
  const auto& [entity_a, entity_b, frame_in_a, frame_in_b, kind, collide_connected, break_force, break_torque] = desc;
  out.Put(entity_a.id.packed());
  out.Put(entity_b.id.packed());
  Put(out, *frame_in_a);
  Put(out, *frame_in_b);
  out.Put(uint8_t(kind.index()));
  std::visit(JointWriter{out}, kind);
  out.Put(collide_connected);
  out.Put(break_force);
  out.Put(break_torque);
}

void Put(ByteWriter& out, const UniformField& field) {
  const auto& [force, acceleration] = field;
  out.Put(force);
  out.Put(acceleration);
}
void Put(ByteWriter& out, const DragField& field) {
  const auto& [linear, quadratic, angular, medium_velocity] = field;
  for (double coefficient : {linear, quadratic, angular}) out.Put(coefficient);
  out.Put(medium_velocity);
}
void Put(ByteWriter& out, const SpringField& field) {
  const auto& [a, b, point_in_a, point_in_b, rest_length, stiffness, damping] = field;
  out.Put(a.packed());
  out.Put(b.packed());
  out.Put(point_in_a);
  out.Put(point_in_b);
  for (double number : {rest_length, stiffness, damping}) out.Put(number);
}
void Put(ByteWriter& out, const PointGravityField& field) {
  const auto& [center, strength, softening] = field;
  out.Put(center);
  out.Put(strength);
  out.Put(softening);
}
void Put(ByteWriter& out, const BuoyancyField& field) {
  const auto& [surface_normal, surface_offset, fluid_density, drag] = field;
  out.Put(surface_normal);
  out.Put(surface_offset);
  out.Put(fluid_density);
  Put(out, drag);
}

void Put(ByteWriter& out, const ForceField& field) {
  const auto& [kind, entities, region] = field;
  out.Put(uint8_t(kind.index()));
  std::visit([&](const auto& each) { Put(out, each); }, kind);
  out.Put(uint64_t{entities.size()});
  for (EntityId id : entities) out.Put(id.packed());
  out.Put(region.has_value());
  if (region) {
    const auto& [corner, opposite_corner] = *region;
    out.Put(corner);
    out.Put(opposite_corner);
  }
}

}  // namespace

void Serialize(const Scene& scene, std::string& bytes) {
  const auto& [world, entities, joints, force_fields] = scene;
  const auto& [engine, gravity, stepper, material, auto_disable, error_correction, ground_plane, recorded, required] =
      world;
  ByteWriter out(bytes);
  out.Put(std::string_view(engine));
  out.Put(gravity);
  Put(out, stepper);
  Put(out, material);
  Put(out, auto_disable);
  Put(out, error_correction);
  out.Put(ground_plane);
  Put(out, recorded);
  for (Feature feature : required) out.Put(static_cast<uint8_t>(feature));
  out.Put(uint64_t{entities.size()});
  for (const std::optional<SceneEntity>& entity : entities) {
    out.Put(entity.has_value());
    if (!entity) continue;
    out.Put(entity->id.packed());
    Put(out, *entity->desc);  // mass properties follow from it
  }
  out.Put(uint64_t{joints.size()});
  for (const std::optional<SceneJoint>& joint : joints) {
    out.Put(joint.has_value());
    if (!joint) continue;
    out.Put(joint->id.packed());
    Put(out, joint->desc);
  }
  out.Put(uint64_t{force_fields.size()});
  for (const auto& [id, field] : force_fields) {
    out.Put(id);
    Put(out, field);
  }
}

void Serialize(const StateArrays& state, std::string& bytes) {
  const auto& [ids, positions, orientations, linear, angular, forces, torques, asleep] = state;
  ByteWriter out(bytes);
  out.Put(uint64_t{ids.size()});
  for (EntityId id : ids) out.Put(id.packed());
  for (const StateArrays::Columns3* column : {&positions, &linear, &angular, &forces, &torques}) out.Put(*column);
  out.Put(orientations);
  out.PutColumn(asleep);
}

void Serialize(const ContactBuffer& solved, std::string& bytes) {
  ByteWriter out(bytes);
  out.Put(uint64_t{solved.pairs.size()});
  for (const ContactPair& pair : solved.pairs) {
    // Which geometries, their order tells; their rows tell also in which order they came to the world.
    for (uint32_t number : {Index(pair.entity_a), Index(pair.entity_b), pair.point_count}) out.Put(number);
    out.Put(pair.owed);
    const bool is_slip_told = pair.material.kinetic_friction != pair.material.friction;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      out.Put(solved.points[i].position);
      out.Put(solved.points[i].normal);
      out.Put(solved.points[i].normal_impulse);
      out.Put(solved.points[i].friction_impulse);
      if (!is_slip_told) continue;
      out.Put(solved.points[i].friction);
      out.Put(Vector3(solved.points[i].relative_velocity + pair.surface_velocity));
    }
  }
}

uint64_t HashBytes(const std::string& bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

}  // namespace genphys

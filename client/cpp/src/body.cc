#include <utility>

#include "genphys/client/options.h"

namespace genphys::client {

EntityDesc Body(const Shape& shape, const BodyOptions& options) {
  Geometry geometry{.shape = shape,
                    .material = {.friction = options.friction,
                                 .restitution = options.restitution,
                                 .density = options.density,
                                 .rolling_friction = options.rolling_friction,
                                 .spinning_friction = options.spinning_friction},
                    .is_sensor = options.is_sensor,
                    .collision_space = options.collision_space,
                    .surface_velocity = options.surface_velocity};
  return {.display_name = options.display_name,
          .pose = {options.position, options.orientation},
          .rigid_body = RigidBody{.motion_type = options.motion_type,
                                  .geometries = {std::move(geometry)},
                                  .inertia = {.mass = options.mass},
                                  .linear_velocity = options.linear_velocity,
                                  .angular_velocity = options.angular_velocity,
                                  .linear_damping = options.linear_damping,
                                  .angular_damping = options.angular_damping,
                                  .gravity_scale = options.gravity_scale,
                                  .locked_axes = options.locked_axes},
          .visual = options.visual};
}

}  // namespace genphys::client

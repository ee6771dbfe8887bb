#include "support/energy.h"

namespace genphys::testing {

double KineticEnergyOf(const World& world) {
  double energy = 0;
  for (const auto& entity : world.scene().entities) {
    if (!entity) continue;
    const EntityRow row{entity->id.index()};
    const Vector3 velocity = world.state().linear_velocities.col(Index(row));
    const Vector3 spin =
        world.state().pose(row).orientation.conjugate() * Vector3(world.state().angular_velocities.col(Index(row)));
    energy += (entity->mass.mass * velocity.squaredNorm() + spin.dot(entity->mass.tensor * spin)) / 2;
  }
  return energy;
}

Vector3 MomentumOf(const World& world) {
  Vector3 momentum = Vector3::Zero();
  for (const auto& entity : world.scene().entities) {
    if (entity) momentum += entity->mass.mass * world.state().linear_velocities.col(entity->id.index());
  }
  return momentum;
}

Vector3 AngularMomentumOf(const World& world) {
  Vector3 momentum = Vector3::Zero();
  for (const auto& entity : world.scene().entities) {
    if (!entity) continue;
    const EntityRow row{entity->id.index()};
    const Pose pose = world.state().pose(row);
    const Vector3 velocity = world.state().linear_velocities.col(Index(row));
    const Vector3 spin = pose.orientation.conjugate() * Vector3(world.state().angular_velocities.col(Index(row)));
    momentum += entity->mass.mass * pose.Transform(entity->mass.center_of_mass).cross(velocity);
    momentum += pose.orientation * (entity->mass.tensor * spin);
  }
  return momentum;
}

}  // namespace genphys::testing

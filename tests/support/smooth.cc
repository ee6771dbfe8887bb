#include "support/smooth.h"

#include "support/scenes.h"

namespace genphys::testing {

EntityDesc Smooth(EntityDesc body, double restitution) {
  Material& material = body.rigid_body->geometries[0].material;
  material.restitution = restitution;
  material.friction = 0;
  material.friction_mixing = Mixing::kMinimum;
  return body;
}

std::unique_ptr<World> FloorOf(const std::string& engine, bool sleeps, Quality quality) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -9.81}, .stepper = {.step_size = 1.0 / 60, .quality = quality}};
  desc.default_auto_disable = {.enabled = sleeps, .rest_time = 0.1};
  return MakeWorld(desc);
}

}  // namespace genphys::testing

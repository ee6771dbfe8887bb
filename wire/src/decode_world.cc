#include <string>
#include <utility>

#include "enums.h"
#include "genphys/wire/decode.h"
#include "material_fields.h"
#include "values.h"

namespace genphys {
namespace {

constexpr std::string_view kEnginePrefix = "engines/";

}  // namespace

Result<std::string> DecodeEngineName(std::string_view name) {
  if (!name.starts_with(kEnginePrefix) || name.size() == kEnginePrefix.size()) {
    return Refuse(Reason::kInvalidValue, "engine", "\"" + std::string(name) + "\" has not the form engines/{engine}");
  }
  return std::string(name.substr(kEnginePrefix.size()));
}

StepperDesc DecodeStepper(const v1::Stepper& stepper) {
  StepperDesc decoded{.quality = DecodeQuality(stepper.quality()),
                      .solver = DecodeSolver(stepper.solver()),
                      .engine_only = stepper.engine_only()};
  if (stepper.has_step_size_seconds()) decoded.step_size = stepper.step_size_seconds();
  if (stepper.has_substeps()) decoded.substeps = stepper.substeps();
  if (stepper.has_iterations()) decoded.iterations = stepper.iterations();
  return decoded;
}

EventKinds DecodeKinds(const v1::EventKinds& kinds) {
  return {.contacts = kinds.contacts(),
          .persisting_contacts = kinds.persisting_contacts(),
          .contact_points = kinds.contact_points(),
          .sensors = kinds.sensors(),
          .sleeping = kinds.sleeping(),
          .moving = kinds.moving(),
          .joints = kinds.joints(),
          .changes = kinds.changes()};
}

Result<WorldDesc> DecodeWorld(const v1::World& world, std::string_view default_engine) {
  WorldDesc decoded{.engine = std::string(default_engine),
                    .stepper = DecodeStepper(world.stepper()),
                    .default_material = DecodeMaterial(world.defaults().material()),
                    .default_auto_disable = DecodeAutoDisable(world.defaults().auto_disable()),
                    .default_error_correction = DecodeErrorCorrection(world.defaults().error_correction())};
  if (!world.engine().empty()) {
    Result<std::string> engine = DecodeEngineName(world.engine());
    if (!engine.ok()) return engine.status();
    decoded.engine = *std::move(engine);
  }
  if (world.has_gravity()) decoded.gravity = DecodeVector(world.gravity());
  if (world.has_ground_plane()) decoded.ground_plane = world.ground_plane();
  if (world.has_recorded_events()) decoded.recorded_events = DecodeKinds(world.recorded_events());
  for (const int feature : world.required_features()) decoded.required_features.push_back(DecodeFeature(feature));
  return decoded;
}

}  // namespace genphys

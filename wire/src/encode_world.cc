#include <string>

#include "enums.h"
#include "genphys/wire/encode.h"
#include "material_fields.h"
#include "values.h"

namespace genphys {

std::string EncodeEngineName(std::string_view engine) {
  return engine.empty() ? std::string() : "engines/" + std::string(engine);
}

void EncodeStepper(const StepperDesc& stepper, v1::Stepper* out) {
  out->set_step_size_seconds(stepper.step_size);
  out->set_quality(EncodeQuality(stepper.quality));
  out->set_solver(EncodeSolver(stepper.solver));
  if (stepper.substeps) out->set_substeps(*stepper.substeps);
  if (stepper.iterations) out->set_iterations(*stepper.iterations);
  out->set_engine_only(stepper.engine_only);
}

void EncodeKinds(const EventKinds& kinds, v1::EventKinds* out) {
  out->set_contacts(kinds.contacts);
  out->set_persisting_contacts(kinds.persisting_contacts);
  out->set_contact_points(kinds.contact_points);
  out->set_sensors(kinds.sensors);
  out->set_sleeping(kinds.sleeping);
  out->set_moving(kinds.moving);
  out->set_joints(kinds.joints);
  out->set_changes(kinds.changes);
}

void EncodeWorld(const WorldDesc& desc, std::string_view name, v1::World::State state, v1::World* out) {
  out->set_name(name.data(), name.size());
  out->set_engine(EncodeEngineName(desc.engine));
  EncodeVector(desc.gravity, out->mutable_gravity());
  EncodeStepper(desc.stepper, out->mutable_stepper());
  EncodeMaterial(desc.default_material, out->mutable_defaults()->mutable_material());
  EncodeAutoDisable(desc.default_auto_disable, out->mutable_defaults()->mutable_auto_disable());
  if (desc.default_error_correction.any()) {
    EncodeErrorCorrection(desc.default_error_correction, out->mutable_defaults()->mutable_error_correction());
  }
  if (desc.ground_plane) out->set_ground_plane(*desc.ground_plane);
  EncodeKinds(desc.recorded_events, out->mutable_recorded_events());
  for (const Feature feature : desc.required_features) out->add_required_features(EncodeFeature(feature));
  out->set_state(state);
}

void EncodeStats(const StepStats& stats, v1::StepStats* out) {
  out->set_entities_asleep(stats.entities_asleep);
  out->set_entities_in_flight(stats.entities_in_flight);
  out->set_entities_in_engine(stats.entities_in_engine);
  out->set_pairs_tested(stats.pairs);
  out->set_contacts(stats.contacts);
  out->set_islands(stats.islands);
  for (const StepStats::Stage& stage : stats.stages) {
    v1::StageTime* time = out->add_stages();
    time->set_stage(stage.name.data(), stage.name.size());
    time->set_nanoseconds(stage.nanoseconds);
  }
}

void EncodeEngine(const Capabilities& capabilities, v1::Engine* out) {
  out->set_name(EncodeEngineName(capabilities.engine()));
  out->set_version(capabilities.version());
  for (int feature = 1; feature < v1::Feature_ARRAYSIZE; ++feature) {
    if (capabilities.Has(DecodeFeature(feature))) out->add_features(static_cast<v1::Feature>(feature));
  }
}

}  // namespace genphys

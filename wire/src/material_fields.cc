#include "material_fields.h"

#include "enums.h"

namespace genphys {

Material DecodeMaterial(const v1::Material& material) {
  Material decoded;
  if (material.has_friction()) decoded.friction = material.friction();
  if (material.has_kinetic_friction()) decoded.kinetic_friction = material.kinetic_friction();
  if (material.has_restitution()) decoded.restitution = material.restitution();
  if (material.has_density()) decoded.density = material.density();
  if (material.has_rolling_friction()) decoded.rolling_friction = material.rolling_friction();
  if (material.has_spinning_friction()) decoded.spinning_friction = material.spinning_friction();
  decoded.friction_mixing = DecodeMixing(material.friction_mixing());
  decoded.restitution_mixing = DecodeMixing(material.restitution_mixing());
  return decoded;
}

void EncodeMaterial(const Material& material, v1::Material* out) {
  if (material.friction) out->set_friction(*material.friction);
  if (material.kinetic_friction) out->set_kinetic_friction(*material.kinetic_friction);
  if (material.restitution) out->set_restitution(*material.restitution);
  if (material.density) out->set_density(*material.density);
  if (material.rolling_friction) out->set_rolling_friction(*material.rolling_friction);
  if (material.spinning_friction) out->set_spinning_friction(*material.spinning_friction);
  if (material.friction_mixing) out->set_friction_mixing(EncodeMixing(*material.friction_mixing));
  if (material.restitution_mixing) out->set_restitution_mixing(EncodeMixing(*material.restitution_mixing));
}

AutoDisable DecodeAutoDisable(const v1::AutoDisable& policy) {
  AutoDisable decoded;
  if (policy.has_enabled()) decoded.enabled = policy.enabled();
  if (policy.has_linear_speed_max()) decoded.linear_speed_max = policy.linear_speed_max();
  if (policy.has_angular_speed_max()) decoded.angular_speed_max = policy.angular_speed_max();
  if (policy.has_rest_time_seconds()) decoded.rest_time = policy.rest_time_seconds();
  return decoded;
}

void EncodeAutoDisable(const AutoDisable& policy, v1::AutoDisable* out) {
  if (policy.enabled) out->set_enabled(*policy.enabled);
  if (policy.linear_speed_max) out->set_linear_speed_max(*policy.linear_speed_max);
  if (policy.angular_speed_max) out->set_angular_speed_max(*policy.angular_speed_max);
  if (policy.rest_time) out->set_rest_time_seconds(*policy.rest_time);
}

ErrorCorrection DecodeErrorCorrection(const v1::ErrorCorrection& correction) {
  ErrorCorrection decoded;
  if (correction.has_time_constant_seconds()) decoded.time_constant = correction.time_constant_seconds();
  if (correction.has_correction_speed_max()) decoded.speed_max = correction.correction_speed_max();
  if (correction.has_slop_metres()) decoded.slop = correction.slop_metres();
  return decoded;
}

void EncodeErrorCorrection(const ErrorCorrection& correction, v1::ErrorCorrection* out) {
  if (correction.time_constant) out->set_time_constant_seconds(*correction.time_constant);
  if (correction.speed_max) out->set_correction_speed_max(*correction.speed_max);
  if (correction.slop) out->set_slop_metres(*correction.slop);
}

}  // namespace genphys

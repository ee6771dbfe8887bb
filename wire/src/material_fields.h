#pragma once
#include "genphys/entity.h"
#include "genphys/material.h"
#include "genphys/status.h"
#include "genphys/v1/entity.pb.h"

// What a geometry or body has of its own and a world as a default: every field may be unset on both sides.

namespace genphys {

Material DecodeMaterial(const v1::Material& material);
void EncodeMaterial(const Material& material, v1::Material* out);

AutoDisable DecodeAutoDisable(const v1::AutoDisable& policy);
void EncodeAutoDisable(const AutoDisable& policy, v1::AutoDisable* out);

/// UNSUPPORTED_FEATURE "error_correction" if any field of it is set.
Status CheckErrorCorrection(const v1::ErrorCorrection& correction);

}  // namespace genphys

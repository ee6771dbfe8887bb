#pragma once
#include "genphys/entity.h"
#include "genphys/material.h"
#include "genphys/v1/entity.pb.h"

// What a geometry or body has of its own and a world as a default: every field may be unset on both sides.

namespace genphys {

Material DecodeMaterial(const v1::Material& material);
void EncodeMaterial(const Material& material, v1::Material* out);

AutoDisable DecodeAutoDisable(const v1::AutoDisable& policy);
void EncodeAutoDisable(const AutoDisable& policy, v1::AutoDisable* out);

ErrorCorrection DecodeErrorCorrection(const v1::ErrorCorrection& correction);
void EncodeErrorCorrection(const ErrorCorrection& correction, v1::ErrorCorrection* out);

}  // namespace genphys

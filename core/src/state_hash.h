#pragma once
#include <string>

#include "genphys/scene.h"
#include "genphys/state.h"

namespace genphys {

/// Appends the description; what a renderer or a person alone looks at (names, visuals) is part of it too.
void Serialize(const Scene& scene, std::string& bytes);

/// Appends the columns.
void Serialize(const StateArrays& state, std::string& bytes);

/// 64-bit hash of `bytes`.
uint64_t HashBytes(const std::string& bytes);

}  // namespace genphys

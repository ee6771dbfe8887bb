#pragma once
#include <string>

#include "genphys/contact.h"
#include "genphys/scene.h"
#include "genphys/state.h"

namespace genphys {

/// Appends the description; what a renderer or a person alone looks at (names, visuals) is part of it too.
void Serialize(const Scene& scene, std::string& bytes);

/// Appends the columns.
void Serialize(const StateArrays& state, std::string& bytes);

/// Appends where which impulses acted, the part of a solved buffer that a later solve can start from.
void Serialize(const ContactBuffer& solved, std::string& bytes);

/// 64-bit hash of `bytes`.
uint64_t HashBytes(const std::string& bytes);

}  // namespace genphys

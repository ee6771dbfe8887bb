#pragma once
#include <memory>

#include "genphys/backend.h"

namespace genphys {

/// Contacts of spheres and planes, and no joints: the engine that docs/adding-an-engine.md makes. Built for tests
/// alone.
std::unique_ptr<Backend> MakeSpheresBackend();

}  // namespace genphys

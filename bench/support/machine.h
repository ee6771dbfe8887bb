#pragma once
#include <iosfwd>
#include <string>
#include <string_view>

#include "genphys/registry.h"

namespace genphys::bench {

/// The moment, as ISO 8601 in UTC.
std::string Now();

/// As a JSON string.
std::string Quoted(std::string_view text);

/// Writes the member "machine" and a comma: a description that does not name it.
void WriteMachine(std::ostream& out);

/// Writes the members "compiler" and "engines", name and version of each, and no comma behind.
void WriteEngines(std::ostream& out, const BackendRegistry& registry);

}  // namespace genphys::bench

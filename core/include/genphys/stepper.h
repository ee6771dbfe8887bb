#pragma once
#include <cstdint>
#include <optional>

namespace genphys {

enum class Solver : uint8_t { kAutomatic, kIterative, kDirect };
enum class Quality : uint8_t { kFast, kBalanced, kAccurate };

/// How a world moves. It can be changed between any two steps.
struct StepperDesc {
  double step_size = 1.0 / 60;  // s
  Quality quality = Quality::kBalanced;
  Solver solver = Solver::kAutomatic;
  std::optional<uint32_t> substeps;    // unset: the preset's
  std::optional<uint32_t> iterations;  // per substep; unset: the preset's
  bool engine_only = false;            // no flight lane: all that is awake goes through the engine
  bool operator==(const StepperDesc&) const = default;
};

/// A stepper as an engine takes it: preset and numbers are settled. With `kAutomatic` the layer solves islands of
/// joints that touch nothing all at once, and the engine chooses for the others; with `kIterative` it is given all
/// rows.
struct StepperSettings {
  Solver solver = Solver::kAutomatic;
  uint32_t substeps = 1;
  uint32_t iterations = 10;
  bool may_go_on = false;  // beyond those where that helps: they are a preset's, and nobody asked for so many
  // Of joints and contacts: an island with joints that touches something is solved all at once with `kAutomatic` while
  // it has no more.
  uint32_t jointed_rows_max = 160;
  bool operator==(const StepperSettings&) const = default;
};

/// How many substeps the presets of an engine have.
struct PresetSubsteps {
  uint32_t fast = 1;
  uint32_t balanced = 2;
  uint32_t accurate = 4;
};

/// `stepper` where a preset has so many substeps, and `iterations` in each.
StepperSettings Settle(const StepperDesc& stepper, uint32_t iterations, const PresetSubsteps& presets = {});

}  // namespace genphys

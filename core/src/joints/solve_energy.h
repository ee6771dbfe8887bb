#pragma once
#include <algorithm>
#include <cmath>

namespace genphys {

/// Kinetic energy of an island while a part of what a solve gave to its velocities is added to them:
/// before + part * first + part^2 * second, J. Once an island is restrained, before is what another solve came to that
/// makes up for no errors.
struct SolveEnergy {
  double first = 0;
  double second = 0;
  double allowed = 0;          // by so much it may grow
  double bend = 0;             // m/s, of the velocity of who turns about its joints, at most, if anybody begins to
  bool is_open = false;        // something moves it that no solve moves
  bool is_restrained = false;  // by part < 1
  bool is_layers = false;      // the layer solved it, not the engine
  bool is_flung = false;       // the engine's solve of it came to nothing that can be
  double part = 1;
  double way = 0;  // the same of places, if that is more; of what an engine solved they take all

  /// Finds the largest part of the solve that gives no more than is allowed. Taking none gives nothing, so that there
  /// is one.
  void Restrain() {
    const double gain = first + second;
    if (is_open || !(gain > allowed) || !std::isfinite(gain)) return;
    is_restrained = true;
    const double root = std::sqrt(first * first + 4 * second * allowed);
    part = first > 0 ? 2 * allowed / (first + root) : (root - first) / (2 * second);
  }
};

}  // namespace genphys

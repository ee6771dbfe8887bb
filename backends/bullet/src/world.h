#pragma once
#include <vector>

#include "dantzig_solver.h"
#include "genphys/swept_world.h"

namespace genphys::bullet_backend {

/// A world on Bullet. The library's exact solver is used, and none of its worlds, dispatchers, trees and pools. Islands
/// that are not for the exact solver are left to the sweeps of the layer.
class World final : public SweptWorld {
 public:
  using SweptWorld::SweptWorld;

  void FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) override;

 private:
  void SolveIsland(uint32_t island, const Call& call) override {
    if (IsForDirect(island, call)) {
      SolveDirectly(island, call, &exact_, true);
    } else {
      Sweep(island, call);
    }
  }

  DantzigSolver exact_;
};

}  // namespace genphys::bullet_backend

#pragma once
#include "genphys/contact.h"
#include "genphys/layer_state.h"

// What methods are predicted to be off by, or promised to be off by at most. A test allows at most twice of what it
// takes from here. Steps are those of solves: see SubstepOf().

namespace genphys::testing {

/// Of numbers of about one that are sums of some hundred products of doubles, each of which rounds by 1e-16.
inline constexpr double kRounded = 1e-12;

/// m: what bears may overlap or gape by so much while it lies still. Every engine owes it, see
/// docs/adding-an-engine.md; who lies on n others may be n times as far from where it would be.
inline constexpr double kTouch = -kTouchingDepth;

/// Of an impulse, relative: what sweeps may leave of it, and what a solve of all rows at once may. Both are promised.
/// The latter comes from the softness of rows: 1e-8 of their mobility, which is up to fifty times that of the centre of
/// mass where arms are long.
inline constexpr double kSwept = 1e-4;
inline constexpr double kDirect = 1e-6;

/// m/s: what sweeps may leave of the speed that a pull of `acceleration` m/s^2 gives in one solve of `step` seconds.
constexpr double SweptSpeed(double acceleration, double step) { return kSwept * acceleration * step; }

/// m: how far off what brakes evenly, by `deceleration` m/s^2, stops. Steps are exact until the one in which it stops:
/// s seconds before the end of braking the way left is a s^2 / 2, and the mean of the speeds at the ends of the step
/// makes it a s h / 2; they differ most at s = h / 2.
constexpr double StopError(double deceleration, double step) { return deceleration * step * step / 8; }

/// m: how deep an impact at `speed` m/s may be found, see kTimedDepth and kTimedPart in core/src/impacts/impacts.cc.
constexpr double ImpactDepth(double speed, double substep) { return 2e-7 + 1e-5 * speed * substep; }

/// m: how much of the height of a flight under `gravity` is missed by who looks at the ends of steps only.
constexpr double ApexMissed(double gravity, double step) { return gravity * step * step / 8; }

/// Of the energy of what joints turn, relative: what steps that turn it by `turn` rad at most give that nothing gave
/// it. The first is as much as the layer lets pass; the other is what a velocity half a step ahead on a circle is off
/// by.
constexpr double Unearned(double turn) { return kUnearnedPart + turn * turn / 8; }

/// m: how far who goes straight on for a step along the tangent of a circle of `radius` m, at `speed` m/s, leaves it.
constexpr double OffCircle(double speed, double step, double radius) {
  return speed * speed * step * step / (2 * radius);
}

/// m: how far a joint opens at `reach` m from what it holds while that turns by `turn` rad in a substep at most: as far
/// as the way that was foretold leaves the circle, as the way that was gone does, and as much again that may wait.
constexpr double Opened(double turn, double reach) { return 3 * OffCircle(turn * reach, 1, reach); }

}  // namespace genphys::testing

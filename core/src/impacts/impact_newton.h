#pragma once
#include <span>

#include "impacts/impact_solve.h"

namespace genphys {

/// More blows than this are not looked at all at once.
inline constexpr size_t kBlowsAtOnce = 8;
/// The same where joints pass blows on, so that sweeps need the more turns.
inline constexpr size_t kTiedBlowsAtOnce = 32;

/// Three numbers of a blow: along its normal, along normal.unitOrthogonal(), and along the cross product of these.
using OfBlow = Vector3;

/// Brings blows on bodies that nothing ties together nearer to Newton's and Coulomb's laws than they are, all at once:
/// where several hit one body, or something heavy meets something light that stands on something, sweeps take many
/// turns. `rates` (m/s, of b against a, along the normal beyond what is asked for) are those of the bodies as they move
/// with the impulses that the blows have; their own velocities are not looked at. False, and nothing changed: it came
/// no nearer. `thoroughly`: where that comes to no end it begins anew without friction, which is brought in by parts.
/// Newton's method on the laws as projections, which are smooth but for edges: Alart and Curnier, "A mixed formulation
/// for frictional contact problems prone to Newton like solution methods", Comput. Methods Appl. Mech. Eng. 92 (1991).
bool SolveAtOnce(std::span<Blow> blows, std::span<const StruckBody> bodies, std::span<const OfBlow> rates,
                 bool thoroughly);

/// The same of blows of which is known how `rates` answer to impulses (1/kg, three rows and columns a blow), whatever
/// ties their bodies together.
bool SolveTiedAtOnce(std::span<Blow> blows, const Eigen::MatrixXd& answers, std::span<const OfBlow> rates,
                     bool thoroughly);

}  // namespace genphys

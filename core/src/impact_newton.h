#pragma once
#include <span>

#include "impact_solve.h"

namespace genphys {

/// More blows than this are not looked at all at once.
inline constexpr size_t kBlowsAtOnce = 8;

/// Brings blows on bodies that nothing ties together nearer to Newton's and Coulomb's laws than they are, all at once:
/// where something heavy meets something light that stands on something, sweeps take as many turns as it is heavier.
/// The bodies move as with the impulses that the blows have. False, and nothing changed: it came no nearer.
/// Newton's method on the laws as projections, which are smooth but for edges: Alart and Curnier, "A mixed formulation
/// for frictional contact problems prone to Newton like solution methods", Comput. Methods Appl. Mech. Eng. 92 (1991).
bool SolveAtOnce(std::span<Blow> blows, std::span<const StruckBody> bodies);

}  // namespace genphys

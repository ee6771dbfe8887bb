#pragma once
#include <cstdint>
#include <string>

namespace genphys::testing {

/// Plays the worlds that seeds from 1 to `count` say on `engine`, each twice and for 300 steps of its own size, and
/// expects that nothing becomes infinite, that hardly anybody is lost, and that both times end with the same bits.
/// Bodies of every shape and of masses from 1e-3 to 1e3 kg begin inside each other, are joined in loops and pushed;
/// some are kicked, moved and deleted on the way.
void ExpectWildWorldsToReplay(const std::string& engine, uint64_t count);

/// Drops what `seed` says on a floor, apart from each other and unjoined, and expects that the total energy never rises
/// above what it was.
void ExpectNoEnergyFromNowhere(const std::string& engine, uint64_t seed);

/// Keeps 200 bodies in a pen for `steps` steps, kicks one of them now and then, and expects that none leaves, that the
/// total energy never rises above what kicks brought, and that the process needs no more memory in the end.
void ExpectPenToLast(const std::string& engine, uint64_t steps);

}  // namespace genphys::testing

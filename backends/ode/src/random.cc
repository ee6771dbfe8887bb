// The iterative solver of ODE reorders its rows at random, from one generator for the whole process: worlds that step
// at the same time would change each other's results. These definitions take the place of the library's, which calls
// its own functions through the dynamic symbol table. The sequence is the library's, and so is the order of rows where
// nobody asked for another one.
#include <ode/misc.h>

#include "library.h"
#include "row_order.h"

namespace {

constexpr uint32_t kMultiplier = 1664525;
constexpr uint32_t kIncrement = 1013904223;

thread_local uint32_t seed = 0;
thread_local uint64_t draws = 0;
thread_local genphys::ode_backend::RowOrder* row_order = nullptr;

uint32_t Draw() {
  ++draws;
  seed = kMultiplier * seed + kIncrement;
  return seed;
}

}  // namespace

extern "C" {

unsigned long dRand() { return Draw(); }

unsigned long dRandGetSeed() { return seed; }

void dRandSetSeed(unsigned long s) { seed = static_cast<uint32_t>(s); }

int dRandInt(int n) {
  if (row_order != nullptr) return row_order->PlaceOfLast(n);
  // The upper bits of the product: the lower bits of such a generator repeat early.
  return static_cast<int>((uint64_t{Draw()} * static_cast<uint64_t>(n)) >> 32);
}

}  // extern "C"

namespace genphys::ode_backend {

uint64_t RandomDraws() { return draws; }

uint32_t DrawRandom() { return Draw(); }

void OrderRowsBy(RowOrder* order) { row_order = order; }

}  // namespace genphys::ode_backend

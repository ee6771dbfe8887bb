#include "outcome.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace genphys::bench {

void Append(Outcome&& more, Outcome& outcome) {
  outcome.rounds = std::max(outcome.rounds, more.rounds);
  outcome.rounds_taken = std::max(outcome.rounds_taken, more.rounds_taken);
  outcome.others = std::max(outcome.others, more.others);
  std::ranges::move(more.costs, std::back_inserter(outcome.costs));
  std::ranges::move(more.figures, std::back_inserter(outcome.figures));
}

}  // namespace genphys::bench

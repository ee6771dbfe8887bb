#include "case.h"

namespace genphys::bench {

std::vector<Case> Cases() {
  std::vector<Case> cases;
  AddFigures(cases);
  AddLinks(cases);
  AddDriven(cases);
  AddStacks(cases);
  AddPoured(cases);
  AddGrounds(cases);
  return cases;
}

}  // namespace genphys::bench

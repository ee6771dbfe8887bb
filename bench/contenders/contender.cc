#include "contender.h"

#include <array>
#include <utility>

#include "genphys_simulation.h"
#include "raw_bullet.h"
#include "raw_ode.h"

namespace genphys::bench {

std::vector<Contender> Contenders(const BackendRegistry& registry) {
  constexpr std::array<std::pair<const char*, Quality>, 3> kPresets{
      {{"fast", Quality::kFast}, {"balanced", Quality::kBalanced}, {"accurate", Quality::kAccurate}}};
  std::vector<Contender> contenders;
  for (const auto& backend : registry.backends()) {
    if (!backend->capabilities().Has(Feature::kContacts)) continue;
    const std::string engine = backend->capabilities().engine();
    for (const auto& [name, quality] : kPresets) {
      const StepperDesc stepper{.quality = quality};
      contenders.push_back({"genphys-" + engine + '-' + name, engine, [&registry, engine, stepper](const Scene& scene) {
                              return SimulateInGenphys(registry, engine, stepper, scene);
                            }});
    }
  }
  const auto raw_ode = [](OdeStepper stepper) {
    return [stepper](const Scene& scene) { return SimulateInRawOde(stepper, scene); };
  };
  contenders.push_back({"raw-ode-step", "ode", raw_ode(OdeStepper::kWorldStep)});
  contenders.push_back({"raw-ode-quick", "ode", raw_ode(OdeStepper::kQuickStep)});
  contenders.push_back({"raw-bullet", "bullet", [](const Scene& scene) { return SimulateInRawBullet(scene); }});
  return contenders;
}

}  // namespace genphys::bench

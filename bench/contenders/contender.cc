#include "contender.h"

#include <array>
#include <utility>

#include "genphys_simulation.h"
#include "raw_bullet.h"
#include "raw_ode.h"

namespace genphys::bench {
namespace {

Contender RawOde(const std::string& name, const OdeSetup& setup) {
  return {name, "ode", [setup](const Scene& scene) { return SimulateInRawOde(setup, scene); }};
}

Contender RawBullet(const std::string& name, const BulletSetup& setup) {
  return {name, "bullet", [setup](const Scene& scene) { return SimulateInRawBullet(setup, scene); }};
}

}  // namespace

std::vector<Contender> Contenders(const BackendRegistry& registry, bool engine_only) {
  constexpr std::array<std::pair<const char*, Quality>, 3> kPresets{
      {{"fast", Quality::kFast}, {"balanced", Quality::kBalanced}, {"accurate", Quality::kAccurate}}};
  std::vector<Contender> contenders;
  for (const auto& backend : registry.backends()) {
    if (!backend->capabilities().Has(Feature::kContacts)) continue;
    const std::string engine = backend->capabilities().engine();
    for (const auto& [name, quality] : kPresets) {
      contenders.push_back(GenphysContender(registry, "genphys-" + engine + '-' + name, engine,
                                            {.quality = quality, .engine_only = engine_only}));
    }
  }
  contenders.push_back(RawOde("raw-ode-step", {.stepper = OdeStepper::kWorldStep}));
  contenders.push_back(RawOde("raw-ode-quick", {}));
  contenders.push_back(RawBullet("raw-bullet", {}));
  return contenders;
}

std::vector<Contender> FrontierContenders(const BackendRegistry& registry) {
  std::vector<Contender> contenders;
  for (const auto& backend : registry.backends()) {
    if (!backend->capabilities().Has(Feature::kContacts)) continue;
    const std::string engine = backend->capabilities().engine();
    const uint32_t preset = backend->Resolve({}).iterations;
    for (const uint32_t substeps : {1u, 2u, 3u, 4u, 6u, 8u}) {
      const std::string name = "genphys-" + engine + '-' + std::to_string(substeps);
      contenders.push_back(GenphysContender(registry, name, engine, {.substeps = substeps}));
      for (const uint32_t iterations : {preset / 2, preset * 2}) {
        contenders.push_back(GenphysContender(registry, name + 'x' + std::to_string(iterations), engine,
                                              {.substeps = substeps, .iterations = iterations}));
      }
    }
  }
  return contenders;
}

Contender GenphysContender(const BackendRegistry& registry, const std::string& name, const std::string& engine,
                           const StepperDesc& stepper) {
  return {name, engine, [&registry, engine, stepper](const Scene& scene) {
            return SimulateInGenphys(registry, engine, stepper, scene);
          }};
}

std::vector<Contender> RawContenders(const std::string& engine) {
  // Enough for a face to lie on another one.
  constexpr int kFewContacts = 4;
  constexpr int kSmallPool = 64;
  constexpr int kLargePool = 65'536;
  if (engine == "ode") {
    return {RawOde("raw-ode-quick", {}), RawOde("raw-ode-hash", {.space = OdeSpace::kHash}),
            RawOde("raw-ode-hash-4", {.space = OdeSpace::kHash, .contacts_max = kFewContacts}),
            RawOde("raw-ode-xyz-4", {.contacts_max = kFewContacts}),
            RawOde("raw-ode-xzy-4", {.space = OdeSpace::kSweepXzy, .contacts_max = kFewContacts})};
  }
  const BulletSetup quick{.updates_all_boxes = false, .is_continuous = false};
  BulletSetup whole = quick, small = quick, large = quick;
  whole.splits_islands = false;
  small.pool_size = kSmallPool;
  large.pool_size = kLargePool;
  return {RawBullet("raw-bullet", {}), RawBullet("raw-bullet-quick", quick), RawBullet("raw-bullet-whole", whole),
          RawBullet("raw-bullet-small", small), RawBullet("raw-bullet-large", large)};
}

}  // namespace genphys::bench

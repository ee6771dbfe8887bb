#include "genphys/backends/spheres.h"
#include "world.h"

namespace genphys {
namespace spheres_backend {
namespace {

constexpr uint32_t kIterations = 50;

class SpheresBackend final : public Backend {
 public:
  const Capabilities& capabilities() const override { return capabilities_; }

  StepperSettings Resolve(const StepperDesc& stepper) const override { return Settle(stepper, kIterations); }

  std::unique_ptr<BackendWorld> CreateWorld(const StepperSettings& settings) const override {
    return std::make_unique<World>(settings);
  }

  // There is no library that could be another one than was compiled against.
  Status SelfTest() const override { return Status(); }

 private:
  const Capabilities capabilities_{"spheres",
                                   "1",
                                   {Feature::kShapeSphere, Feature::kShapePlane, Feature::kContacts, Feature::kRayCasts,
                                    Feature::kShapeQueries, Feature::kSensors, Feature::kSolverIterative}};
};

}  // namespace
}  // namespace spheres_backend

std::unique_ptr<Backend> MakeSpheresBackend() { return std::make_unique<spheres_backend::SpheresBackend>(); }

}  // namespace genphys

#include "genphys/backends/ballistic.h"
#include "world.h"

namespace genphys {
namespace ballistic_backend {
namespace {

class BallisticBackend final : public Backend {
 public:
  const Capabilities& capabilities() const override { return capabilities_; }

  StepperSettings Resolve(const StepperDesc& stepper) const override {
    // Nothing is iterated, so one round is all there is to choose.
    return Settle(stepper, 1);
  }

  std::unique_ptr<BackendWorld> CreateWorld(const StepperSettings&) const override { return std::make_unique<World>(); }

  Status SelfTest() const override { return Status(); }

 private:
  // Neither contacts, rays nor sensors. Without planes a world gets no floor that would hold nothing.
  const Capabilities capabilities_{"ballistic",
                                   "1",
                                   {Feature::kShapeSphere, Feature::kShapeBox, Feature::kShapeCapsule,
                                    Feature::kShapeCylinder, Feature::kLockedAxes}};
};

}  // namespace
}  // namespace ballistic_backend

std::unique_ptr<Backend> MakeBallisticBackend() { return std::make_unique<ballistic_backend::BallisticBackend>(); }

}  // namespace genphys

#include <ode/ode.h>

#include <algorithm>

#include "absl/status/status.h"
#include "genphys/backends/ode.h"
#include "library.h"
#include "world.h"

namespace genphys {
namespace ode_backend {
namespace {

class OdeBackend final : public Backend {
 public:
  OdeBackend() { StartLibrary(); }

  const Capabilities& capabilities() const override { return capabilities_; }

  StepperSettings Resolve(const StepperDesc& stepper) const override {
    return Settle(stepper, ContactSweeps::kPresetIterations);
  }

  std::unique_ptr<BackendWorld> CreateWorld(const StepperSettings& settings) const override {
    PrepareThread();
    return std::make_unique<World>(settings);
  }

  Status SelfTest() const override {
    if (dCheckConfiguration("ODE_double_precision") == 0) {
      return absl::InternalError("the ODE that is linked computes in single precision, and its headers in double");
    }
    return absl::OkStatus();
  }

 private:
  const Capabilities capabilities_{
      "ode",
      dODE_VERSION,
      {Feature::kShapeSphere,  Feature::kShapeBox,        Feature::kShapeCapsule,      Feature::kShapeCylinder,
       Feature::kShapePlane,   Feature::kShapeConvexHull, Feature::kShapeTriangleMesh, Feature::kShapeHeightfield,
       Feature::kShapeCone,    Feature::kShapeEllipsoid,  Feature::kContacts,          Feature::kRayCasts,
       Feature::kShapeQueries, Feature::kSensors,         Feature::kSolverIterative,   Feature::kSolverDirect,
       Feature::kJointBall,    Feature::kJointHinge,      Feature::kJointSlider,       Feature::kJointUniversal,
       Feature::kJointFixed,   Feature::kJointWheel,      Feature::kJointSixDof,       Feature::kErrorCorrection,
       Feature::kLockedAxes,   Feature::kSurfaceVelocity, Feature::kJointDistance,     Feature::kJointGear}};
};

}  // namespace
}  // namespace ode_backend

std::unique_ptr<Backend> MakeOdeBackend() { return std::make_unique<ode_backend::OdeBackend>(); }

}  // namespace genphys

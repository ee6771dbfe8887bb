#include <ode/ode.h>

#include <algorithm>

#include "absl/status/status.h"
#include "genphys/backends/ode.h"
#include "library.h"
#include "world.h"

namespace genphys {
namespace ode_backend {
namespace {

constexpr uint32_t kSubstepsFast = 1;
constexpr uint32_t kSubstepsBalanced = 2;
constexpr uint32_t kSubstepsAccurate = 4;

uint32_t SubstepsOf(Quality quality) {
  switch (quality) {
    case Quality::kFast:
      return kSubstepsFast;
    case Quality::kBalanced:
      return kSubstepsBalanced;
    case Quality::kAccurate:
      return kSubstepsAccurate;
  }
  return kSubstepsBalanced;
}

class OdeBackend final : public Backend {
 public:
  OdeBackend() { StartLibrary(); }

  const Capabilities& capabilities() const override { return capabilities_; }

  StepperSettings Resolve(const StepperDesc& stepper) const override {
    return {.solver = stepper.solver,
            .substeps = stepper.substeps.value_or(SubstepsOf(stepper.quality)),
            .iterations = stepper.iterations.value_or(ContactSweeps::kPresetIterations)};
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

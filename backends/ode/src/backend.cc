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

// Enough contacts for the solver to want random numbers: boxes that each touch the ground with four corners.
Status CheckRandomNumbersAreOurs() {
  constexpr uint32_t kBodies = 8;
  constexpr uint32_t kCorners = 4;
  MassProperties mass;
  mass.mass = 1;
  mass.tensor = mass.inverse_tensor = Matrix3::Identity();
  ContactSolver solver({.solver = Solver::kIterative});
  solver.Begin(kBodies, 1.0 / 60, ContactBuffer::kUsualPull);
  solver.Reserve(kBodies * kCorners, 0, 0, false);
  for (uint32_t body = 0; body < kBodies; ++body) {
    solver.SetBody(body, mass, Motion{.linear_velocity = {0, 0, -1}});
    for (uint32_t corner = 0; corner < kCorners; ++corner) {
      const Vector3 position(corner < 2 ? 1 : -1, corner % 2 == 0 ? 1 : -1, -1);
      solver.AddContact({.body = body, .position = position, .friction = 1});
    }
  }
  const uint64_t before = RandomDraws();
  solver.Step();
  if (RandomDraws() == before) {
    return absl::InternalError(
        "ODE draws random numbers from its own generator, which its worlds share: link the program so that it exports "
        "dRand, dRandInt, dRandSetSeed and dRandGetSeed");
  }
  return absl::OkStatus();
}

class OdeBackend final : public Backend {
 public:
  OdeBackend() { StartLibrary(); }

  const Capabilities& capabilities() const override { return capabilities_; }

  StepperSettings Resolve(const StepperDesc& stepper) const override {
    return {.solver = stepper.solver,
            .substeps = stepper.substeps.value_or(SubstepsOf(stepper.quality)),
            .iterations = stepper.iterations.value_or(ContactSolver::kPresetIterations)};
  }

  std::unique_ptr<BackendWorld> CreateWorld(const StepperSettings& settings) const override {
    PrepareThread();
    return std::make_unique<World>(settings);
  }

  Status SelfTest() const override {
    if (dCheckConfiguration("ODE_double_precision") == 0) {
      return absl::InternalError("the ODE that is linked computes in single precision, and its headers in double");
    }
    try {
      PrepareThread();
      return CheckRandomNumbersAreOurs();
    } catch (const EngineFault& fault) {
      return absl::InternalError(fault.what());
    }
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

#include <BulletCollision/CollisionShapes/btBoxShape.h>

#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "genphys/backends/bullet.h"
#include "world.h"

namespace genphys {
namespace bullet_backend {
namespace {

constexpr uint32_t kSubstepsFast = 1;
constexpr uint32_t kSubstepsBalanced = 2;
constexpr uint32_t kSubstepsAccurate = 8;

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

// Rounding in single precision would show in the eighth digit of what compiled code of the library computes.
Status CheckPrecision() {
  constexpr double kThird = 1.0 / 3;
  btVector3 moments(0, 0, 0);
  btBoxShape(btVector3(kThird, kThird, kThird)).calculateLocalInertia(1, moments);
  const double expected = 2.0 / 27;
  if (std::abs(moments.x() - expected) > 1e-14) {
    return absl::InternalError(absl::StrCat(
        "the Bullet that is linked does not compute in double precision: ", moments.x(), " instead of ", expected));
  }
  return absl::OkStatus();
}

// The adapter reaches into the solver of the library: a body that falls on a fixed one must be stopped by it.
Status CheckSolver() {
  constexpr double kMass = 2, kSpeed = 3, kStepSize = 0.01;
  RigidBody described;
  MassProperties mass;
  mass.mass = kMass;
  mass.tensor = mass.inverse_tensor = Matrix3::Identity();
  StateArrays state;
  state.Resize(1);
  state.set_pose(EntityRow{0}, Pose{});
  state.linear_velocities.col(0) = Vector3(0, 0, -kSpeed);
  state.angular_velocities.col(0).setZero();
  Body body({.row = EntityRow{0}, .id = EntityId(0, 1), .body = described, .mass = mass, .geometries = {}}, state);
  body.LoadRigid(state);
  ContactPoint point{.position = Vector3(0, 0, -1), .normal = Vector3::UnitZ()};
  PointImpulse impulse;
  const ContactPair pair;
  ContactSolver solver;
  solver.SetIterations(ContactSweeps::kPresetIterations);
  solver.Begin(kStepSize, ContactBuffer::kUsualPull, true);
  solver.AddBody(body);
  solver.AddPair(nullptr, &body, pair, {&point, 1}, {&impulse, 1});
  solver.Solve(false);
  if (body.solved.linear_velocity.norm() > 1e-12 || std::abs(point.normal_impulse - kMass * kSpeed) > 1e-12) {
    return absl::InternalError("the solver of the Bullet that is linked is not the one its headers describe");
  }
  return absl::OkStatus();
}

class BulletBackend final : public Backend {
 public:
  const Capabilities& capabilities() const override { return capabilities_; }

  StepperSettings Resolve(const StepperDesc& stepper) const override {
    return {.solver = stepper.solver,
            .substeps = stepper.substeps.value_or(SubstepsOf(stepper.quality)),
            .iterations = stepper.iterations.value_or(ContactSweeps::kPresetIterations)};
  }

  std::unique_ptr<BackendWorld> CreateWorld(const StepperSettings& settings) const override {
    return std::make_unique<World>(settings);
  }

  Status SelfTest() const override {
    GENPHYS_RETURN_IF_ERROR(CheckPrecision());
    return CheckSolver();
  }

 private:
  const Capabilities capabilities_{
      "bullet",
      absl::StrCat(btGetVersion() / 100, ".", btGetVersion() % 100),
      {Feature::kShapeSphere,  Feature::kShapeBox,        Feature::kShapeCapsule,      Feature::kShapeCylinder,
       Feature::kShapePlane,   Feature::kShapeConvexHull, Feature::kShapeTriangleMesh, Feature::kShapeHeightfield,
       Feature::kShapeCone,    Feature::kShapeEllipsoid,  Feature::kContacts,          Feature::kRayCasts,
       Feature::kShapeQueries, Feature::kSensors,         Feature::kSolverIterative,   Feature::kSolverDirect,
       Feature::kJointBall,    Feature::kJointHinge,      Feature::kJointSlider,       Feature::kJointUniversal,
       Feature::kJointFixed,   Feature::kJointWheel,      Feature::kJointSixDof,       Feature::kErrorCorrection,
       Feature::kLockedAxes,   Feature::kSurfaceVelocity, Feature::kJointDistance,     Feature::kJointGear}};
};

}  // namespace
}  // namespace bullet_backend

std::unique_ptr<Backend> MakeBulletBackend() { return std::make_unique<bullet_backend::BulletBackend>(); }

}  // namespace genphys

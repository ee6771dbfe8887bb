#include <BulletCollision/CollisionShapes/btBoxShape.h>

#include <cmath>
#include <limits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "dantzig_solver.h"
#include "genphys/backends/bullet.h"
#include "world.h"

namespace genphys {
namespace bullet_backend {
namespace {

constexpr uint32_t kSubstepsAccurate = 8;

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

// The adapter calls into a solver of which the library's own worlds make no use: something pressed by 1 N*s, against
// which friction of half of that brakes what would take 2.
Status CheckSolver() {
  const Eigen::MatrixXd matrix = 2 * Eigen::Matrix2d::Identity();
  const BoundedSolver::Bounds bounds[] = {{0, std::numeric_limits<double>::infinity()}, {-0.5, 0.5, 0}};
  Eigen::VectorXd impulses;
  if (!DantzigSolver().Solve(matrix, Eigen::Vector2d(2, 4), bounds, impulses) ||
      (impulses - Eigen::Vector2d(1, 0.5)).norm() > 1e-14) {
    return absl::InternalError("the exact solver of the Bullet that is linked is not the one its headers describe");
  }
  return absl::OkStatus();
}

class BulletBackend final : public Backend {
 public:
  const Capabilities& capabilities() const override { return capabilities_; }

  StepperSettings Resolve(const StepperDesc& stepper) const override {
    return Settle(stepper, ContactSweeps::kPresetIterations, {.accurate = kSubstepsAccurate});
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

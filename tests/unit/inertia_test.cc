#include "genphys/inertia.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "support/sweep.h"

namespace genphys {
namespace {

using std::numbers::pi;

// Products and sums of a few doubles.
constexpr double kRounding = 1e-12;

RigidBody BodyOf(const Shape& shape) {
  return {.geometries = {Geometry{.shape = shape, .material = {.density = 1000.0}}}};
}

bool Inside(const Shape& shape, const Vector3& p) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return p.norm() <= s->radius;
  if (const auto* b = std::get_if<Box>(&shape)) return (p.cwiseAbs().array() <= b->half_extents.array()).all();
  if (const auto* c = std::get_if<Cylinder>(&shape)) {
    return p.head<2>().norm() <= c->radius && std::abs(p.z()) <= c->half_length;
  }
  if (const auto* c = std::get_if<Cone>(&shape)) {
    return std::abs(p.z()) <= c->half_length &&
           p.head<2>().norm() <= c->radius * (c->half_length - p.z()) / (2 * c->half_length);
  }
  if (const auto* e = std::get_if<Ellipsoid>(&shape)) return p.cwiseQuotient(e->semi_axes).norm() <= 1;
  if (const auto* c = std::get_if<Capsule>(&shape)) {
    const double beyond = std::max(0.0, std::abs(p.z()) - c->half_length);
    return std::hypot(p.head<2>().norm(), beyond) <= c->radius;
  }
  return false;
}

class ClosedForms : public ::testing::TestWithParam<Shape> {};

// An independent reference: the integrals of volume and tensor by midpoint sums over a fine lattice, of which the box
// covers whole cells.
TEST_P(ClosedForms, AgreeWithSumsOverALattice) {
  constexpr int kCells = kSweepStride == 1 ? 160 : 80;
  constexpr double kHalfWidth = 1.3;
  constexpr double kLatticeError =
      1.6 / kCells;  // relative; surface cells over all cells, with signs that mostly cancel
  constexpr double kCell = 2 * kHalfWidth / kCells;
  double volume = 0;
  Vector3 center = Vector3::Zero();
  Matrix3 tensor = Matrix3::Zero();
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      for (int k = 0; k < kCells; ++k) {
        const Vector3 p = Vector3(i + 0.5, j + 0.5, k + 0.5) * kCell - Vector3::Constant(kHalfWidth);
        if (!Inside(GetParam(), p)) continue;
        volume += kCell * kCell * kCell;
        center += kCell * kCell * kCell * p;
        tensor += kCell * kCell * kCell * (p.squaredNorm() * Matrix3::Identity() - p * p.transpose());
      }
    }
  }

  center /= volume;
  // About the centre, by Steiner's theorem.
  tensor -= volume * (center.squaredNorm() * Matrix3::Identity() - center * center.transpose());

  EXPECT_NEAR(Volume(GetParam()) / volume, 1, kLatticeError);
  EXPECT_LT((CenterOfMass(GetParam()) - center).norm(), kLatticeError);
  EXPECT_LE((UnitDensityTensor(GetParam()) - tensor).norm(), kLatticeError * tensor.norm());
}

INSTANTIATE_TEST_SUITE_P(Shapes, ClosedForms,
                         ::testing::Values(Shape(Sphere{0.9}), Shape(Box{{0.39, 0.715, 1.105}}),
                                           Shape(Capsule{0.4, 0.6}), Shape(Cylinder{0.5, 0.8}), Shape(Cone{0.9, 1.105}),
                                           Shape(Ellipsoid{{0.7, 0.9, 1.2}})));

TEST(MassProperties, OfAConeLieWhereItsMassIs) {
  RigidBody body = BodyOf(Cone{0.3, 0.4});
  body.geometries[0].pose_in_entity = {{1, 2, 3}, Quaternion(Eigen::AngleAxisd(pi, Vector3::UnitX()))};

  const Result<MassProperties> mass = ComputeMassProperties(body);

  ASSERT_TRUE(mass.ok());
  // Upside down, its heavy end is up.
  EXPECT_LT((mass->center_of_mass - Vector3(1, 2, 3.2)).norm(), kRounding);
  // Across the axis and about the apex it is 3/20 r^2 + 3/5 h^2, and the centre lies 3/4 h from there.
  const double across = mass->mass * (0.15 * 0.09 + 0.6 * 0.64 - 0.36);
  EXPECT_NEAR(mass->tensor(0, 0) / across, 1, kRounding);
  EXPECT_NEAR(mass->tensor(2, 2) / (0.3 * mass->mass * 0.09), 1, kRounding);
}

TEST(MassProperties, OfACompoundFollowSteiner) {
  RigidBody body;
  for (double x : {-2.0, 1.0}) {
    Geometry ball{.shape = Sphere{0.5}, .material = {.density = 3 / (4 * pi * 0.125)}};  // 1 kg each
    ball.pose_in_entity.position.x() = x;
    body.geometries.push_back(ball);
  }

  const Result<MassProperties> mass = ComputeMassProperties(body);

  ASSERT_TRUE(mass.ok());
  EXPECT_NEAR(mass->mass, 2, kRounding);
  EXPECT_LE((mass->center_of_mass - Vector3(-0.5, 0, 0)).norm(), kRounding);
  EXPECT_NEAR(mass->tensor(0, 0), 2 * 0.4 * 0.25, kRounding);
  EXPECT_NEAR(mass->tensor(1, 1), 2 * 0.4 * 0.25 + 2 * 1.5 * 1.5, kRounding);
  EXPECT_FALSE(mass->spherical);
}

TEST(MassProperties, AMassAloneScalesTheTensorOfTheShapes) {
  RigidBody body = BodyOf(Box{{0.5, 1, 2}});
  const Matrix3 dense = ComputeMassProperties(body)->tensor;
  const double weight = ComputeMassProperties(body)->mass;
  body.inertia.mass = 2.0;

  const Result<MassProperties> mass = ComputeMassProperties(body);

  ASSERT_TRUE(mass.ok());
  EXPECT_LE((mass->tensor - dense * (2 / weight)).norm(), kRounding * dense.norm());
}

TEST(MassProperties, OfAShapeFarFromItsEntityAreThoseOfTheShape) {
  RigidBody near = BodyOf(Box{{1e-5, 2e-5, 3e-5}}), far = near;
  far.geometries[0].pose_in_entity.position = {1e7, -1e7, 3e6};

  const MassProperties expected = *ComputeMassProperties(near), got = *ComputeMassProperties(far);

  EXPECT_LE((got.tensor - expected.tensor).norm(), kRounding * expected.tensor.norm());
}

TEST(MassProperties, OfANeedleCanBeInvertedHoweverItLies) {
  // The smallest moment is raised to 1e-12 of the largest, and the inverse of that has four digits left.
  constexpr double kDigits = 1e-3;
  for (const double angle : {0.0, 0.3, 1.0}) {
    RigidBody needle = BodyOf(Cylinder{1e-5, 1e5});
    needle.geometries[0].pose_in_entity.orientation = Eigen::AngleAxisd(angle, Vector3(1, 2, 0).normalized());

    const MassProperties mass = *ComputeMassProperties(needle);

    EXPECT_LE((mass.inverse_tensor * mass.tensor - Matrix3::Identity()).norm(), kDigits) << angle;
  }
}

TEST(MassProperties, ABallTurnsUniformly) { EXPECT_TRUE(ComputeMassProperties(BodyOf(Sphere{0.5}))->spherical); }

TEST(MassProperties, SensorsWeighNothing) {
  RigidBody body = BodyOf(Sphere{0.5});
  const double weight = ComputeMassProperties(body)->mass;
  body.geometries.push_back(Geometry{.shape = Box{}, .material = {.density = 1000.0}, .is_sensor = true});

  EXPECT_EQ(ComputeMassProperties(body)->mass, weight);
}

TEST(MassProperties, NeedAMassWhereThereIsNoVolume) {
  const Result<MassProperties> mass = ComputeMassProperties(RigidBody{});

  ASSERT_FALSE(mass.ok());
  EXPECT_EQ(RefusalOf(mass.status())->reason, Reason::kMissingField);
  EXPECT_EQ(RefusalOf(mass.status())->field, "inertia.mass");
}

TEST(Tensor, MayBeThatOfAFlatPlateButNotOfNothing) {
  const auto check = [](double x, double y, double z) { return CheckTensor(Vector3(x, y, z).asDiagonal(), "tensor"); };
  EXPECT_TRUE(check(1, 1, 2).ok());
  EXPECT_EQ(RefusalOf(check(1, 1, 2.01))->reason, Reason::kInvalidValue);
  EXPECT_EQ(RefusalOf(check(1, 1, 0))->reason, Reason::kInvalidValue);
  EXPECT_EQ(RefusalOf(check(1, 1, -1))->reason, Reason::kInvalidValue);
}

}  // namespace
}  // namespace genphys

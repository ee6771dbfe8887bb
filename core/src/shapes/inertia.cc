#include "genphys/inertia.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>

#include "genphys/convex_hull.h"

namespace genphys {
namespace {

using std::numbers::pi;

// Rounding in a tensor that a client computed itself must not make a flat plate impossible.
constexpr double kTriangleSlack = 1e-6;
// Principal moments below this part of the largest cannot be told from nothing, and make the inverse meaningless.
constexpr double kMomentRatioMin = 1e-12;
// Relative difference of principal moments below which rotation without torque is taken as uniform.
constexpr double kSphericalTolerance = 1e-12;

Matrix3 Diagonal(double x, double y, double z) { return Vector3(x, y, z).asDiagonal(); }

// Parallel axis theorem: the tensor of mass m moved by d.
Matrix3 Steiner(double mass, const Vector3& d) {
  return mass * (d.squaredNorm() * Matrix3::Identity() - d * d.transpose());
}

struct VolumeOf {
  double operator()(const Sphere& s) const { return 4.0 / 3.0 * pi * s.radius * s.radius * s.radius; }
  double operator()(const Box& b) const { return 8 * b.half_extents.prod(); }
  double operator()(const Capsule& c) const {
    return pi * c.radius * c.radius * (2 * c.half_length + 4.0 / 3.0 * c.radius);
  }
  double operator()(const Cylinder& c) const { return 2 * pi * c.radius * c.radius * c.half_length; }
  double operator()(const Plane&) const { return 0; }
  double operator()(const Cone& c) const { return 2.0 / 3.0 * pi * c.radius * c.radius * c.half_length; }
  double operator()(const Ellipsoid& e) const { return 4.0 / 3.0 * pi * e.semi_axes.prod(); }
  double operator()(const ConvexHull& h) const { return h.data->volume; }
  double operator()(const TriangleMesh&) const { return 0; }
  double operator()(const Heightfield&) const { return 0; }
};

struct CenterOf {
  // A cone's lies at a quarter of its height.
  Vector3 operator()(const Cone& c) const { return {0, 0, -c.half_length / 2}; }
  Vector3 operator()(const ConvexHull& h) const { return h.data->center_of_mass; }
  template <typename Symmetric>
  Vector3 operator()(const Symmetric&) const {
    return Vector3::Zero();
  }
};

// Closed forms for solids of uniform density, as in any table of moments of inertia (e.g. Goldstein, Classical
// Mechanics, ch. 5); the capsule is a cylinder and two half balls moved outwards by Steiner's theorem.
struct TensorOf {
  Matrix3 operator()(const Sphere& s) const {
    const double moment = 0.4 * VolumeOf{}(s)*s.radius * s.radius;
    return Diagonal(moment, moment, moment);
  }
  Matrix3 operator()(const Box& b) const {
    const Vector3 sq = b.half_extents.cwiseAbs2();
    return VolumeOf{}(b) / 3 * Diagonal(sq.y() + sq.z(), sq.x() + sq.z(), sq.x() + sq.y());
  }
  Matrix3 operator()(const Cylinder& c) const {
    const double volume = VolumeOf{}(c);
    const double across = volume * (c.radius * c.radius / 4 + c.half_length * c.half_length / 3);
    return Diagonal(across, across, volume * c.radius * c.radius / 2);
  }
  Matrix3 operator()(const Capsule& c) const {
    const double r = c.radius, h = c.half_length;
    const Matrix3 middle = (*this)(Cylinder{r, h});
    const double caps = 4.0 / 3.0 * pi * r * r * r;
    const double along = 0.4 * caps * r * r;
    // A half ball about its flat centre has 2/5 m r^2; its own centre lies 3/8 r further out.
    const double across = along + caps * (h * h + 0.75 * h * r);
    return middle + Diagonal(across, across, along);
  }
  Matrix3 operator()(const Plane&) const { return Matrix3::Zero(); }
  Matrix3 operator()(const Cone& c) const {
    const double mass = VolumeOf{}(c), square = c.radius * c.radius;
    // 3/20 r^2 + 3/80 of the squared height.
    const double across = 0.15 * mass * (square + c.half_length * c.half_length);
    return Diagonal(across, across, 0.3 * mass * square);
  }
  Matrix3 operator()(const Ellipsoid& e) const {
    const Vector3 sq = e.semi_axes.cwiseAbs2();
    return VolumeOf{}(e) / 5 * Diagonal(sq.y() + sq.z(), sq.x() + sq.z(), sq.x() + sq.y());
  }
  Matrix3 operator()(const ConvexHull& h) const { return h.data->tensor; }
  Matrix3 operator()(const TriangleMesh&) const { return Matrix3::Zero(); }
  Matrix3 operator()(const Heightfield&) const { return Matrix3::Zero(); }
};

struct Sum {
  double mass = 0;
  Vector3 center = Vector3::Zero();  // of mass
  Matrix3 tensor = Matrix3::Zero();  // about the centre
};

// Of all solid geometries at their densities, in the frame of the entity. Sensors weigh nothing.
Sum SumOf(const std::vector<Geometry>& geometries) {
  Sum sum;
  const auto visit_solids = [&](const auto& visit) {
    for (const Geometry& geometry : geometries) {
      if (!geometry.is_sensor) visit(geometry, *geometry.material.density * Volume(geometry.shape));
    }
  };
  visit_solids([&](const Geometry& geometry, double mass) {
    sum.mass += mass;
    sum.center += mass * geometry.pose_in_entity.Transform(CenterOfMass(geometry.shape));
  });
  if (!(sum.mass > 0)) return {};
  sum.center /= sum.mass;
  // About the centre from the start: far from the origin, nothing of the tensor would be left after moving it there.
  visit_solids([&](const Geometry& geometry, double mass) {
    const Matrix3 rotation = geometry.pose_in_entity.orientation.toRotationMatrix();
    sum.tensor += *geometry.material.density * rotation * UnitDensityTensor(geometry.shape) * rotation.transpose() +
                  Steiner(mass, geometry.pose_in_entity.Transform(CenterOfMass(geometry.shape)) - sum.center);
  });
  return sum;
}

// A needle's smallest moment is lost in the rounding of its largest, and may come out as nothing or less. It is then
// made as small as can be told.
Matrix3 WithoutLostMoments(const Matrix3& tensor) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(tensor);
  const double smallest = kMomentRatioMin * solver.eigenvalues()[2];
  if (solver.eigenvalues()[0] > smallest) return tensor;
  const Vector3 moments = solver.eigenvalues().cwiseMax(smallest);
  return solver.eigenvectors() * moments.asDiagonal() * solver.eigenvectors().transpose();
}

bool IsSpherical(const Matrix3& tensor) {
  const double mean = tensor.trace() / 3;
  return (tensor - mean * Matrix3::Identity()).cwiseAbs().maxCoeff() <= kSphericalTolerance * mean;
}

}  // namespace

double Volume(const Shape& shape) { return std::visit(VolumeOf{}, shape); }

Vector3 CenterOfMass(const Shape& shape) { return std::visit(CenterOf{}, shape); }

Matrix3 UnitDensityTensor(const Shape& shape) { return std::visit(TensorOf{}, shape); }

Status CheckTensor(const Matrix3& tensor, std::string_view field) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(tensor, Eigen::EigenvaluesOnly);
  const Vector3 moments = solver.eigenvalues();  // ascending
  if (!(moments[0] > kMomentRatioMin * moments[2])) {
    return Refuse(Reason::kInvalidValue, field, "the inertia tensor is not positive definite");
  }
  if (moments[0] + moments[1] < moments[2] * (1 - kTriangleSlack)) {
    return Refuse(Reason::kInvalidValue, field,
                  "no body has these principal moments: the sum of two is never less than the third");
  }
  return absl::OkStatus();
}

Result<MassProperties> ComputeMassProperties(const RigidBody& body) {
  const Sum sum = SumOf(body.geometries);
  const InertiaDesc& given = body.inertia;
  MassProperties result;
  if (!given.mass && !(sum.mass > 0)) {
    return Refuse(Reason::kMissingField, "inertia.mass",
                  "a dynamic body without a solid shape that has volume needs inertia.mass");
  }
  result.mass = given.mass.value_or(sum.mass);
  result.center_of_mass = given.center_of_mass.value_or(sum.center);
  if (given.tensor) {
    GENPHYS_RETURN_IF_ERROR(CheckTensor(*given.tensor, "inertia.tensor"));
    result.tensor = *given.tensor;
  } else if (sum.mass > 0) {
    // The same form about the centre that was asked for, scaled to the mass that was asked for.
    result.tensor = WithoutLostMoments(sum.tensor * (result.mass / sum.mass) +
                                       Steiner(result.mass, result.center_of_mass - sum.center));
  } else {
    return Refuse(Reason::kMissingField, "inertia.tensor",
                  "a dynamic body without a solid shape that has volume needs inertia.tensor");
  }
  result.tensor = (0.5 * (result.tensor + result.tensor.transpose())).eval();
  result.inverse_tensor = result.tensor.inverse();
  result.spherical = IsSpherical(result.tensor);
  return result;
}

}  // namespace genphys

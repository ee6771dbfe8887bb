#include "contacts/even_share.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace genphys {
namespace {

// How many points of a face tell no more than three do.
constexpr size_t kRedundant = 4;
// The cosine between normals of one face is no further from one.
constexpr double kSameFace = 1e-9;
// The least determinant, of the largest that there could be, with which points do not lie on one line.
constexpr double kNoLine = 1e-9;

}  // namespace

void ShareEvenly(std::span<const ContactPoint> points, std::span<PointImpulse> impulses) {
  if (points.size() < kRedundant) return;
  const Vector3& normal = points[0].normal;
  const auto is_of_face = [&](const ContactPoint& point) {
    return !point.is_ahead && point.normal.dot(normal) > 1 - kSameFace;
  };
  if (!std::ranges::all_of(points, is_of_face)) return;
  const Vector3& origin = points[0].position;
  const Vector3 x = normal.unitOrthogonal(), y = normal.cross(x);
  const auto place = [&](size_t i) {
    const Vector3 from = points[i].position - origin;
    return Vector3(1, from.dot(x), from.dot(y));
  };
  Matrix3 squares = Matrix3::Zero();
  Vector3 load = Vector3::Zero();
  for (size_t i = 0; i < points.size(); ++i) {
    squares += place(i) * place(i).transpose();
    load += impulses[i].normal * place(i);
  }
  if (!(squares.determinant() > kNoLine * squares(0, 0) * squares(1, 1) * squares(2, 2))) return;
  const Vector3 pressure = squares.ldlt().solve(load);
  // As far as no point pulls.
  double part = 1;
  for (size_t i = 0; i < points.size(); ++i) {
    const double shared = pressure.dot(place(i)), had = impulses[i].normal;
    if (shared < 0) part = std::min(part, had / (had - shared));
  }
  for (size_t i = 0; i < points.size(); ++i) {
    impulses[i].normal += part * (pressure.dot(place(i)) - impulses[i].normal);
  }
}

}  // namespace genphys

#pragma once
#include <Eigen/Core>

#include "genphys/shape.h"

namespace genphys {

/// 1/m: the surface turns by so much per metre at an edge or a corner, where it turns on the spot.
inline constexpr double kSharp = 1e6;

/// How the outward normal of a shape turns per metre along its surface, in two directions across it, 1/m.
using Curvature = Eigen::Matrix2d;
/// Two directions of unit length across a normal and each other.
using Tangents = Eigen::Matrix<double, 3, 2>;

/// At `point` where `shape` touches something with the outward `normal`, all in its frame. Where nothing tells it, as
/// of hulls and surfaces, it is taken to be flat, and so is the rim of what stands on it with `is_wide`, at several
/// points around it.
Curvature CurvatureAt(const Shape& shape, const Vector3& point, const Vector3& normal, const Tangents& tangents,
                      bool is_wide);

}  // namespace genphys

#include "genphys/capabilities.h"

#include <array>
#include <utility>

namespace genphys {

std::string_view NameOf(Feature feature) {
  static constexpr std::array<std::string_view, static_cast<size_t>(Feature::kCount)> kNames{"unspecified",
                                                                                             "shape_sphere",
                                                                                             "shape_box",
                                                                                             "shape_capsule",
                                                                                             "shape_cylinder",
                                                                                             "shape_plane",
                                                                                             "shape_convex_hull",
                                                                                             "shape_triangle_mesh",
                                                                                             "shape_heightfield",
                                                                                             "contacts",
                                                                                             "ray_casts",
                                                                                             "sensors",
                                                                                             "solver_iterative",
                                                                                             "solver_direct",
                                                                                             "joint_ball",
                                                                                             "joint_hinge",
                                                                                             "joint_slider",
                                                                                             "joint_universal",
                                                                                             "joint_fixed",
                                                                                             "error_correction",
                                                                                             "continuous_collision",
                                                                                             "exact_snapshot",
                                                                                             "shape_cone",
                                                                                             "shape_ellipsoid",
                                                                                             "dynamic_triangle_mesh",
                                                                                             "dynamic_heightfield",
                                                                                             "shape_queries",
                                                                                             "joint_wheel",
                                                                                             "joint_six_dof",
                                                                                             "joint_distance",
                                                                                             "joint_gear",
                                                                                             "locked_axes",
                                                                                             "surface_velocity"};
  return kNames[static_cast<size_t>(feature)];
}

Feature FeatureOf(const Shape& shape) {
  struct Visitor {
    Feature operator()(const Sphere&) const { return Feature::kShapeSphere; }
    Feature operator()(const Box&) const { return Feature::kShapeBox; }
    Feature operator()(const Capsule&) const { return Feature::kShapeCapsule; }
    Feature operator()(const Cylinder&) const { return Feature::kShapeCylinder; }
    Feature operator()(const Plane&) const { return Feature::kShapePlane; }
    Feature operator()(const Cone&) const { return Feature::kShapeCone; }
    Feature operator()(const Ellipsoid&) const { return Feature::kShapeEllipsoid; }
    Feature operator()(const ConvexHull&) const { return Feature::kShapeConvexHull; }
    Feature operator()(const TriangleMesh&) const { return Feature::kShapeTriangleMesh; }
    Feature operator()(const Heightfield&) const { return Feature::kShapeHeightfield; }
  };
  return std::visit(Visitor{}, shape);
}

Feature FeatureOf(const JointKind& kind) {
  struct Visitor {
    Feature operator()(const BallJoint&) const { return Feature::kJointBall; }
    Feature operator()(const HingeJoint&) const { return Feature::kJointHinge; }
    Feature operator()(const SliderJoint&) const { return Feature::kJointSlider; }
    Feature operator()(const UniversalJoint&) const { return Feature::kJointUniversal; }
    Feature operator()(const FixedJoint&) const { return Feature::kJointFixed; }
    Feature operator()(const WheelJoint&) const { return Feature::kJointWheel; }
    Feature operator()(const SixDofJoint&) const { return Feature::kJointSixDof; }
    Feature operator()(const DistanceJoint&) const { return Feature::kJointDistance; }
    Feature operator()(const GearJoint&) const { return Feature::kJointGear; }
  };
  return std::visit(Visitor{}, kind);
}

Capabilities::Capabilities(std::string engine, std::string version, std::initializer_list<Feature> features)
    : engine_(std::move(engine)), version_(std::move(version)) {
  for (Feature feature : features) features_.set(static_cast<size_t>(feature));
}

}  // namespace genphys

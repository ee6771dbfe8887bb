#include "gauges.h"

#include <algorithm>
#include <cmath>

namespace genphys::bench {

double HingeAngle(const Simulation& simulation, const Scene& scene, size_t joint) {
  const JointDesc& desc = scene.joints.at(joint);
  const auto turned = [&](const EntityRef& ref, const Pose& frame) {
    const std::optional<size_t> place = PlaceOf(ref);
    return place ? Quaternion(simulation.MotionOf(*place).orientation * frame.orientation) : frame.orientation;
  };
  const Quaternion between =
      turned(desc.entity_a, *desc.frame_in_a).conjugate() * turned(desc.entity_b, *desc.frame_in_b);
  return 2 * std::atan2(between.w() < 0 ? -between.z() : between.z(), std::abs(between.w()));
}

Gauge Drift() {
  return {"farthest aside, m", [](const Simulation& simulation, const Scene& scene, double) {
            double drift = 0;
            for (size_t i = 0; i < scene.bodies.size(); ++i) {
              if (!IsDynamic(scene.bodies[i])) continue;
              const Vector3 way = simulation.MotionOf(i).position - scene.bodies[i].pose.position;
              drift = std::max(drift, way.head<2>().norm());
            }
            return drift;
          }};
}

Gauge SpeedAlongX() {
  return {"mean speed along x, m/s", [](const Simulation& simulation, const Scene& scene, double) {
            double sum = 0;
            size_t count = 0;
            for (size_t i = 0; i < scene.bodies.size(); ++i) {
              if (!IsDynamic(scene.bodies[i])) continue;
              sum += simulation.MotionOf(i).velocity.x();
              ++count;
            }
            return sum / static_cast<double>(count);
          }};
}

}  // namespace genphys::bench

#include "sight.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "contenders/run.h"
#include "genphys/bounds.h"
#include "genphys/world.h"
#include "support/must.h"

namespace genphys::bench {
namespace {

double RadiusOf(const EntityDesc& body) {
  double radius = 0;
  for (const Geometry& geometry : body.rigid_body->geometries) {
    radius = std::max(radius, geometry.pose_in_entity.position.norm() + BoundingRadius(geometry.shape));
  }
  return radius;
}

// A body that stays where it is put.
EntityDesc Still(const EntityDesc& body, const Pose& pose) {
  EntityDesc still = body;
  still.pose = pose;
  still.rigid_body->motion_type = MotionType::kStatic;
  still.rigid_body->inertia = {};
  still.rigid_body->linear_velocity.setZero();
  still.rigid_body->angular_velocity.setZero();
  return still;
}

}  // namespace

Observer::Observer(const BackendRegistry& registry, const Scene& scene, double lowest)
    : registry_(registry), scene_(scene), lowest_(lowest) {
  for (const EntityDesc& body : scene.bodies) radii_.push_back(RadiusOf(body));
  for (const JointDesc& joint : scene.joints) {
    const std::optional<size_t> a = PlaceOf(joint.entity_a), b = PlaceOf(joint.entity_b);
    if (a && b) joined_.push_back(std::minmax(*a, *b));
  }
  std::sort(joined_.begin(), joined_.end());
}

Sight Observer::Look(const Simulation& simulation) const {
  Sight sight;
  std::vector<Pose> poses;
  std::vector<bool> lost;
  size_t count = 0;
  for (size_t i = 0; i < scene_.bodies.size(); ++i) {
    const EntityDesc& body = scene_.bodies[i];
    poses.push_back(body.pose);
    lost.push_back(false);
    if (!IsDynamic(body)) continue;
    const Motion motion = simulation.MotionOf(i);
    const double turn = motion.orientation.norm();
    lost[i] = !motion.position.allFinite() || !motion.velocity.allFinite() || !(turn > 0) ||
              motion.position.z() < lowest_ || motion.position.norm() > 1e6;
    if (lost[i]) {
      ++sight.lost;
      continue;
    }
    poses[i] = {motion.position, motion.orientation.normalized()};
    sight.speed += motion.velocity.norm();
    ++count;
  }
  if (count > 0) sight.speed /= static_cast<double>(count);
  sight.gap = sight.lost == 0 ? JointGap(simulation, scene_) : std::numeric_limits<double>::quiet_NaN();
  sight.overlap = OverlapOf(poses, lost);
  return sight;
}

double Observer::OverlapOf(const std::vector<Pose>& poses, const std::vector<bool>& lost) const {
  // A world of ours in which all of them lie still can say how far two are from each other.
  const std::unique_ptr<World> world = Must(World::Create(registry_, {.engine = "ode"}));
  std::vector<Command> commands;
  for (size_t i = 0; i < poses.size(); ++i) {
    commands.emplace_back(CreateEntity{Still(scene_.bodies[i], lost[i] ? Pose{} : poses[i])});
  }
  RigidBody floor{.motion_type = MotionType::kStatic};
  floor.geometries.push_back({.shape = Plane{}});
  commands.emplace_back(CreateEntity{{.rigid_body = floor}});
  const std::vector<CreatedId> ids = Must(world->Apply(commands));

  std::vector<EntityId> from, to;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (lost[i]) continue;
    const bool moves = IsDynamic(scene_.bodies[i]);
    if (moves && scene_.has_ground) {
      from.emplace_back(ids[i]);
      to.emplace_back(ids.back());
    }
    for (size_t j = i + 1; j < poses.size(); ++j) {
      if (lost[j] || (!moves && !IsDynamic(scene_.bodies[j]))) continue;
      if ((poses[i].position - poses[j].position).norm() > radii_[i] + radii_[j]) continue;
      if (std::binary_search(joined_.begin(), joined_.end(), std::pair(i, j))) continue;
      from.emplace_back(ids[i]);
      to.emplace_back(ids[j]);
    }
  }
  double deepest = 0;
  for (const ClosestPoints& points : Must(world->MeasureDistances(from, to))) {
    if (!points.hit.entity.is_null()) deepest = std::max(deepest, -points.distance);
  }
  return deepest;
}

}  // namespace genphys::bench

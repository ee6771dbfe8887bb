#include "genphys/scene.h"

#include <limits>
#include <utility>

namespace genphys {
namespace {

BodyTraits TraitsOf(const EntityDesc& desc) {
  if (!desc.rigid_body) return {};
  const RigidBody& body = *desc.rigid_body;
  const AutoDisable& policy = body.auto_disable;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  return {.is_dynamic = body.motion_type == MotionType::kDynamic,
          .is_free = !body.linear_speed_max && !body.angular_speed_max && !body.locked_axes.any(),
          .is_locked = body.locked_axes.any(),
          .may_sleep = *policy.enabled,
          .corrects = body.error_correction.any(),
          .gravity_scale = body.gravity_scale,
          .linear_damping = body.linear_damping,
          .angular_damping = body.angular_damping,
          .linear_speed_max = body.linear_speed_max.value_or(kNone),
          .angular_speed_max = body.angular_speed_max.value_or(kNone),
          .rest_speed = *policy.linear_speed_max,
          .rest_spin = *policy.angular_speed_max,
          .rest_time = *policy.rest_time};
}

}  // namespace

SceneEntity::SceneEntity(EntityId its_id, std::shared_ptr<const EntityDesc> its_desc, const MassProperties& its_mass)
    : id(its_id), desc(std::move(its_desc)), mass(its_mass), traits(TraitsOf(*desc)) {}

void SceneEntity::Become(std::shared_ptr<const EntityDesc> other, const MassProperties& other_mass) {
  *this = SceneEntity(id, std::move(other), other_mass);
}

}  // namespace genphys

#include "genphys_simulation.h"

#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "genphys/limits.h"
#include "genphys/world.h"

namespace genphys::bench {
namespace {

template <typename T>
T Expect(Result<T> result) {
  if (!result.ok()) throw std::runtime_error(std::string(result.status().message()));
  return *std::move(result);
}

WorldDesc Describe(const std::string& engine, const StepperDesc& stepper, const Scene& scene) {
  WorldDesc desc{.engine = engine, .gravity = scene.gravity, .stepper = stepper};
  desc.default_material = {.friction = scene.friction, .restitution = scene.restitution};
  desc.default_auto_disable.enabled = scene.may_sleep;
  desc.ground_plane = scene.has_ground;
  desc.recorded_events = {.contacts = false,
                          .contact_points = false,
                          .sensors = false,
                          .sleeping = false,
                          .joints = false,
                          .changes = false};
  return desc;
}

class GenphysSimulation final : public Simulation {
 public:
  GenphysSimulation(const BackendRegistry& registry, const WorldDesc& desc, const Scene& scene)
      : world_(Expect(World::Create(registry, desc))) {
    std::vector<Command> commands;
    for (const EntityDesc& body : scene.bodies) commands.emplace_back(CreateEntity{body});
    for (const JointDesc& joint : scene.joints) commands.emplace_back(CreateJoint{joint});
    const std::vector<CreatedId> ids = Expect(world_->Apply(commands));
    bodies_.assign(ids.begin(), ids.begin() + static_cast<ptrdiff_t>(scene.bodies.size()));
    joints_.assign(ids.begin() + static_cast<ptrdiff_t>(scene.bodies.size()), ids.end());
  }

  void Step(double step_size) override {
    if (const Status status = world_->Step(step_size); !status.ok()) {
      throw std::runtime_error(std::string(status.message()));
    }
  }

  Motion MotionOf(size_t body) const override {
    const StateArrays& state = world_->state();
    const uint32_t row = bodies_.at(body).index();
    return {state.positions.col(row), FromColumn(state.orientations.col(row)), state.linear_velocities.col(row),
            state.angular_velocities.col(row)};
  }

  void Hold(size_t body, const Vector3& force, const Vector3& torque) override {
    Apply(ApplyForce{
        .id = bodies_.at(body), .force = force, .torque = torque, .steps = Limits::kForceStepsMax, .replace = true});
  }

  void Kick(size_t body, const Vector3& impulse) override {
    Apply(ApplyImpulse{.id = bodies_.at(body), .linear = impulse});
  }

  void SetGravity(const Vector3& gravity) override { Apply(genphys::SetGravity{gravity}); }
  void Remove(size_t body) override { Apply(DeleteEntity{bodies_.at(body)}); }
  void Release(size_t joint) override { Apply(DeleteJoint{joints_.at(joint)}); }

  void Aim(std::span<const size_t> joints, std::span<const double> positions,
           std::span<const double> velocities) override {
    SetMotorColumns columns{.velocities = {velocities.begin(), velocities.end()},
                            .positions = {positions.begin(), positions.end()}};
    for (const size_t joint : joints) columns.ids.push_back(joints_.at(joint));
    Apply(columns);
  }

  StepStats Explain(double step_size) override {
    world_->set_record_stats(true);
    Step(step_size);
    world_->set_record_stats(false);
    return world_->stats();
  }

 private:
  void Apply(const Command& command) { Expect(world_->Apply({&command, 1})); }

  std::unique_ptr<World> world_;
  std::vector<EntityId> bodies_;
  std::vector<JointId> joints_;
};

}  // namespace

std::unique_ptr<Simulation> SimulateInGenphys(const BackendRegistry& registry, const std::string& engine,
                                              const StepperDesc& stepper, const Scene& scene) {
  return std::make_unique<GenphysSimulation>(registry, Describe(engine, stepper, scene), scene);
}

}  // namespace genphys::bench

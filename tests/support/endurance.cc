#include "support/endurance.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>
#include <vector>

#include "support/joints.h"
#include "support/random.h"
#include "support/scenes.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

constexpr int kSteps = 300;

Shape AnySolid(Random& random, double low, double high) {
  const auto size = [&] { return random.LogUniform(low, high); };
  const double a = size(), b = size(), c = size();
  switch (random.Below(7)) {
    case 0:
      return Sphere{a};
    case 1:
      return Box{{a, b, c}};
    case 2:
      return Capsule{a, b};
    case 3:
      return Cylinder{a, b};
    case 4:
      return Cone{a, b};
    case 5:
      return Ellipsoid{{a, b, c}};
    default:
      return HullBox({a, b, c}, random.Turn());
  }
}

JointKind AnyKind(Random& random) {
  switch (random.Below(5)) {
    case 0:
      return BallJoint{};
    case 1:
      return HingeJoint{};
    case 2:
      return SliderJoint{};
    case 3:
      return FixedJoint{};
    default:
      return DistanceJoint{};
  }
}

StepperDesc AnyStepper(Random& random, double step_size) {
  StepperDesc stepper{.step_size = step_size, .quality = static_cast<Quality>(random.Below(3))};
  if (random.Chance(0.2)) stepper.solver = Solver::kIterative;
  return stepper;
}

// What a seed says; its world can be made and played again.
class WildWorld {
 public:
  WildWorld(const std::string& engine, uint64_t seed) : random_(seed) {
    WorldDesc desc{.engine = engine, .gravity = {0, 0, -9.81}};
    step_size_ = random_.LogUniform(1e-4, 1.0 / 30);
    desc.stepper = AnyStepper(random_, step_size_);
    desc.default_material = {.friction = random_.Uniform(0, 1), .restitution = random_.Uniform(0, 1)};
    world_ = MakeWorld(desc);
    constexpr size_t kBodies = 12;
    for (size_t i = 0; i < kBodies; ++i) AddBody();
    for (size_t i = 1; i < kBodies; ++i) {
      if (random_.Chance(0.4)) JoinTo(i, random_.Below(i));
    }
    for (const EntityId id : ids_) {
      if (random_.Chance(0.3)) Push(id);
    }
  }

  /// False when a step was refused or something is infinite.
  bool Play() {
    for (int step = 0; step < kSteps; ++step) {
      if (random_.Chance(0.05)) Disturb();
      const Status status = world_->Step();
      EXPECT_TRUE(status.ok()) << status << " at step " << step;
      const StateArrays& state = world_->state();
      const bool finite = state.positions.allFinite() && state.orientations.allFinite() &&
                          state.linear_velocities.allFinite() && state.angular_velocities.allFinite();
      EXPECT_TRUE(finite) << "at step " << step;
      if (!status.ok() || !finite) return false;
    }
    return true;
  }

  uint64_t hash() const { return world_->StateHash(); }
  /// Whether somebody left the bounds of the world.
  bool TakeLoss() { return !Of<EntityFaulted>(world_->TakeEvents()).empty(); }

 private:
  double MassOf(EntityId id) const { return world_->scene().entities[id.index()]->mass.mass; }
  EntityId AnyBody() { return ids_[random_.Below(ids_.size())]; }

  void AddBody() {
    const Shape shape = AnySolid(random_, 0.05, 0.5);
    const Vector3 place = random_.Vector(1.2) + Vector3(0, 0, 2);
    EntityDesc desc = Body(shape, place, random_.LogUniform(1e-3, 1e3));
    desc.pose.orientation = random_.Turn();
    desc.rigid_body->linear_velocity = random_.Vector(3);
    desc.rigid_body->angular_velocity = random_.Vector(5);
    ids_.push_back(Add(*world_, desc));
  }

  void JoinTo(size_t body, size_t other) {
    JointDesc joint = Between(ids_[other], ids_[body], AnyKind(random_));
    joint.collide_connected = random_.Chance(0.3);
    joined_.insert({ids_[other], ids_[body]});
    Join(*world_, joint);
  }

  void Push(EntityId id) {
    const double mass = MassOf(id);
    Do(*world_, ApplyForce{.id = id, .force = mass * random_.Vector(20), .steps = kSteps});
  }

  void Disturb() {
    const EntityId id = AnyBody();
    switch (random_.Below(5)) {
      case 0:
        Do(*world_, ApplyImpulse{.id = id, .linear = MassOf(id) * random_.Vector(3)});
        break;
      case 1:
        // A joint that is torn apart by metres has to come together within steps, at whatever speed that takes.
        if (joined_.contains(id)) break;
        Do(*world_, SetPose{.id = id, .position = random_.Vector(1) + Vector3(0, 0, 2)});
        break;
      case 2:
        Do(*world_, SetGravity{random_.Vector(10)});
        break;
      case 3:
        Do(*world_, SetStepper{AnyStepper(random_, step_size_)});
        break;
      default:
        if (ids_.size() < 3) break;
        Do(*world_, DeleteEntity{id});
        std::erase(ids_, id);
    }
  }

  Random random_;
  double step_size_ = 0;
  std::unique_ptr<World> world_;
  std::vector<EntityId> ids_;
  std::set<EntityId> joined_;
};

// Of motion and weight, J.
double EnergyOf(const World& world) {
  double energy = 0;
  const StateArrays& state = world.state();
  for (const std::optional<SceneEntity>& entity : world.scene().entities) {
    if (!entity || !entity->desc->rigid_body || entity->desc->rigid_body->motion_type != MotionType::kDynamic) continue;
    const EntityRow row{entity->id.index()};
    const Pose pose = state.pose(row);
    const Vector3 velocity = state.linear_velocities.col(Index(row));
    const Vector3 spin = pose.orientation.conjugate() * Vector3(state.angular_velocities.col(Index(row)));
    const MassProperties& mass = entity->mass;
    energy += (mass.mass * velocity.squaredNorm() + spin.dot(mass.tensor * spin)) / 2;
    energy -= mass.mass * world.scene().world.gravity.dot(pose.Transform(mass.center_of_mass));
  }
  return energy;
}

double ResidentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

}  // namespace

void ExpectWildWorldsToReplay(const std::string& engine, uint64_t count) {
  // A gram that is joined or squeezed between hundreds of kilograms may be thrown out with some of these step sizes.
  constexpr double kLostShareMax = 0.05;
  uint64_t lost = 0;
  for (uint64_t seed = 1; seed <= count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed) + " on " + engine);
    WildWorld first(engine, seed), second(engine, seed);
    if (!first.Play() || !second.Play()) continue;
    EXPECT_EQ(first.hash(), second.hash());
    lost += first.TakeLoss() ? 1 : 0;
  }
  EXPECT_LE(static_cast<double>(lost), std::ceil(kLostShareMax * static_cast<double>(count)));
}

void ExpectNoEnergyFromNowhere(const std::string& engine, uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed) + " on " + engine);
  // What pushing bodies out of each other may add, of the energy that it began with.
  constexpr double kRepair = 0.05;
  constexpr double kApart = 1.8;  // m: more than the largest is long
  Random random(seed);
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -9.81}};
  desc.stepper = AnyStepper(random, random.LogUniform(1e-3, 1.0 / 30));
  desc.default_material = {.friction = random.Uniform(0, 1), .restitution = random.Uniform(0, 1)};
  const std::unique_ptr<World> world = MakeWorld(desc);
  constexpr int kRow = 2;
  for (int i = 0; i < kRow * kRow * kRow; ++i) {
    const Vector3 cell(i % kRow, i / kRow % kRow, i / kRow / kRow);
    EntityDesc body = Body(AnySolid(random, 0.1, 0.4), kApart * cell + Vector3(0, 0, 1), random.LogUniform(0.1, 10));
    body.pose.orientation = random.Turn();
    body.rigid_body->angular_velocity = random.Vector(3);
    Add(*world, body);
  }
  const double start = EnergyOf(*world);
  double most = start;
  for (int step = 0; step < kSteps; ++step) {
    Steps(*world, 1);
    most = std::max(most, EnergyOf(*world));
  }
  EXPECT_LE(most, start * (1 + kRepair));
}

void ExpectPenToLast(const std::string& engine, uint64_t steps) {
  constexpr size_t kBodies = 200;
  constexpr double kHalf = 5;              // m
  constexpr uint64_t kBetweenKicks = 500;  // steps
  // MB, after the first tenth: buffers grow with the fullest step that there was, and a leak of every step does not
  // end.
  constexpr double kMemoryGrowthMax = 2;
  Random random(1);
  const std::unique_ptr<World> world = MakeWorld(engine);
  for (const Vector3& normal : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0), Vector3(0, -1, 0)}) {
    EntityDesc wall = Body(Plane{normal, -kHalf}, Vector3::Zero());
    wall.rigid_body->motion_type = MotionType::kStatic;
    Add(*world, wall);
  }
  std::vector<EntityId> ids;
  for (size_t i = 0; i < kBodies; ++i) {
    const Vector3 place(random.Uniform(-4, 4), random.Uniform(-4, 4), 1 + 0.1 * static_cast<double>(i));
    EntityDesc body = Body(AnySolid(random, 0.1, 0.3), place);
    body.pose.orientation = random.Turn();
    ids.push_back(Add(*world, body));
  }
  double allowed = EnergyOf(*world), memory = 0;
  for (uint64_t step = 1; step <= steps; ++step) {
    ASSERT_TRUE(world->Step().ok()) << "step " << step;
    world->TakeEvents();
    if (step == steps / 10) memory = ResidentMegabytes();
    if (step % kBetweenKicks != 0) continue;
    const double before = EnergyOf(*world);
    ASSERT_LE(before, allowed) << "step " << step;
    Do(*world, ApplyImpulse{.id = ids[random.Below(kBodies)], .linear = random.Vector(4) + Vector3(0, 0, 2)});
    allowed += EnergyOf(*world) - before;
  }
  for (const EntityId id : ids) {
    const Vector3 place = PositionOf(*world, id);
    EXPECT_TRUE(place.z() > 0 && place.head<2>().cwiseAbs().maxCoeff() < kHalf) << place.transpose();
  }
  EXPECT_LE(ResidentMegabytes(), memory + kMemoryGrowthMax);
}

}  // namespace genphys::testing

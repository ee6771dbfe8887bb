#include "support/random_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "support/joints.h"
#include "support/scenes.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

constexpr double kMassMin = 1e-3, kMassMax = 1e3;  // kg
constexpr double kCell = 2;                        // m between the bodies of the crowd, each within a ball of 1 m
constexpr int kSide = 3;
constexpr double kCrowdEnd = 50;  // m: fields reach no farther
constexpr double kApart = 200;    // m

class Builder {
 public:
  Builder(const std::vector<std::string>& engines, uint64_t seed) : engines_(engines), random_(seed) {}

  RandomScene Build() {
    MakeEmptyWorld();
    AddGround();
    for (int i = 0; i < kSide * kSide * 2; ++i) {
      if (random_.Chance(0.7)) AddBody({i % kSide - 1.0, i / kSide % kSide - 1.0, 0.6 + i / (kSide * kSide)});
    }
    for (size_t i = 0; i < movers_.size(); ++i) {
      if (random_.Chance(0.5)) AddJoint(i);
    }
    AddFields();
    AddForces();
    AddThoseApart();
    return std::move(scene_);
  }

 private:
  bool Can(Feature feature) const {
    return std::all_of(engines_.begin(), engines_.end(),
                       [&](const std::string& name) { return EveryEngine().Find(name)->capabilities().Has(feature); });
  }

  void MakeEmptyWorld() {
    WorldDesc desc{.engine = engines_.front(), .gravity = {0, 0, -random_.Uniform(1, 20)}};
    desc.stepper.step_size = 1 / random_.Uniform(30, 120);
    desc.stepper.quality = static_cast<Quality>(random_.Below(3));
    if (random_.Chance(0.3)) desc.stepper.substeps = 1 + random_.Below(4);
    if (random_.Chance(0.3) && Can(Feature::kSolverIterative)) desc.stepper.solver = Solver::kIterative;
    desc.default_material = AnyMaterial();
    desc.recorded_events = {.persisting_contacts = random_.Chance(0.5), .moving = random_.Chance(0.5)};
    scene_.world = MakeWorld(desc);
  }

  Material AnyMaterial() {
    Material material;
    if (random_.Chance(0.7)) material.friction = random_.Uniform(0, 1.5);
    if (random_.Chance(0.3)) material.kinetic_friction = random_.Uniform(0, 1);
    if (random_.Chance(0.5)) material.restitution = random_.Uniform(0, 1);
    if (random_.Chance(0.3)) material.friction_mixing = static_cast<Mixing>(random_.Below(5));
    if (random_.Chance(0.3)) material.restitution_mixing = static_cast<Mixing>(random_.Below(5));
    return material;
  }

  double Size() { return random_.LogUniform(0.05, 0.4); }

  Shape AnySolid() {
    std::vector<std::function<Shape()>> makers{[&] { return Sphere{Size()}; }};
    const auto offer = [&](Feature feature, std::function<Shape()> maker) {
      if (Can(feature)) makers.push_back(std::move(maker));
    };
    const auto extents = [&] { return Vector3(Size(), Size(), Size()); };
    offer(Feature::kShapeBox, [&] { return Box{extents()}; });
    offer(Feature::kShapeCapsule, [&] { return Capsule{Size(), Size()}; });
    offer(Feature::kShapeCylinder, [&] { return Cylinder{Size(), Size()}; });
    offer(Feature::kShapeCone, [&] { return Cone{Size(), Size()}; });
    offer(Feature::kShapeEllipsoid, [&] { return Ellipsoid{extents()}; });
    offer(Feature::kShapeConvexHull, [&] { return HullBox(extents(), random_.Turn()); });
    return makers[random_.Below(makers.size())]();
  }

  void AddGround() {
    const double phase = random_.Uniform(0, 6);
    const auto hills = [&](double x, double y) { return 0.2 * std::sin(x + phase) * std::cos(y - phase); };
    std::vector<Shape> grounds;
    if (Can(Feature::kShapeTriangleMesh)) grounds.push_back(GroundMesh(6, 8, hills));
    if (Can(Feature::kShapeHeightfield)) grounds.push_back(Ground(13, 1, hills));
    if (grounds.empty() || random_.Chance(0.4)) return;
    EntityDesc ground = Body(grounds[random_.Below(grounds.size())], {0, 0, 0.1});
    ground.rigid_body->motion_type = MotionType::kStatic;
    Add(*scene_.world, ground);
  }

  Geometry AnyGeometry(bool has_offset) {
    static constexpr std::array<const char*, 5> kSpaces{"", "", "", "car", "car/wheels"};
    Geometry geometry{.shape = AnySolid(), .material = AnyMaterial()};
    if (has_offset) geometry.pose_in_entity = {random_.Vector(0.3), random_.Turn()};
    if (random_.Chance(0.3)) geometry.category_bits = 1 + random_.Below(3);
    if (random_.Chance(0.2)) geometry.collides_with_bits = 1 + random_.Below(3);
    geometry.collision_space = kSpaces[random_.Below(kSpaces.size())];
    geometry.is_sensor = Can(Feature::kSensors) && random_.Chance(0.1);
    return geometry;
  }

  void AddBody(const Vector3& cell) {
    EntityDesc desc;
    desc.display_name = "one of the crowd";
    desc.pose = {kCell * cell + random_.Vector(0.05), random_.Turn()};
    if (random_.Chance(0.1)) desc.visual = Visual{"crowd.glb", "model/gltf-binary", "bytes"};
    if (random_.Chance(0.05)) {
      Add(*scene_.world, desc);  // nothing but a picture
      return;
    }
    RigidBody body{.inertia = {.mass = random_.LogUniform(kMassMin, kMassMax)}};
    const size_t count = 1 + random_.Below(3);
    for (size_t i = 0; i < count; ++i) body.geometries.push_back(AnyGeometry(count > 1));
    // A sensor has no mass.
    if (!random_.Chance(0.1)) body.geometries[0].is_sensor = false;
    const double kind = random_.Uniform(0, 1);
    body.motion_type = kind < 0.1 ? MotionType::kStatic : kind < 0.25 ? MotionType::kKinematic : MotionType::kDynamic;
    const auto is_sensor = [](const Geometry& geometry) { return geometry.is_sensor; };
    if (std::all_of(body.geometries.begin(), body.geometries.end(), is_sensor)) {
      body.inertia.tensor = 0.01 * *body.inertia.mass * Matrix3::Identity();
    }
    if (body.motion_type != MotionType::kStatic && random_.Chance(0.7)) {
      body.linear_velocity = random_.Vector(2);
      body.angular_velocity = random_.Vector(3);
    }
    if (random_.Chance(0.3)) body.linear_damping = random_.Uniform(0, 2);
    if (random_.Chance(0.3)) body.angular_damping = random_.Uniform(0, 2);
    if (random_.Chance(0.2)) body.gravity_scale = random_.Uniform(-0.5, 1.5);
    if (random_.Chance(0.2)) body.linear_speed_max = random_.Uniform(1, 10);
    if (random_.Chance(0.2)) body.angular_speed_max = random_.Uniform(1, 10);
    if (random_.Chance(0.3)) body.auto_disable = {random_.Chance(0.5), 0.1, 0.2, 0.1};
    const bool is_mover = body.motion_type == MotionType::kDynamic;
    if (is_mover) movers_.push_back({{}, *body.inertia.mass});
    desc.rigid_body = std::move(body);
    const EntityId id = Add(*scene_.world, desc);
    if (is_mover) movers_.back().first = id;
  }

  // `strength` is what moves the axis: a mass or a moment.
  JointAxis AnyAxis(double middle, double range, double strength) {
    JointAxis axis;
    if (random_.Chance(0.5)) axis.limits.lower = middle - random_.Uniform(0.1, 1) * range;
    if (random_.Chance(0.5)) axis.limits.upper = middle + random_.Uniform(0.1, 1) * range;
    const double kind = random_.Uniform(0, 1);
    if (kind < 0.2) {
      axis.motor = Motor{.target_velocity = random_.Uniform(-2, 2), .force_max = strength * random_.Uniform(1, 20)};
    } else if (kind < 0.4) {
      axis.motor = Motor{.target_position = middle + random_.Uniform(-0.5, 0.5) * range,
                         .stiffness = strength * random_.Uniform(10, 200),
                         .damping = strength * random_.Uniform(0, 5)};
    } else if (kind < 0.6) {
      axis.spring = Spring{strength * random_.Uniform(5, 100), strength * random_.Uniform(0, 3), middle};
    }
    return axis;
  }

  JointKind AnyKind(double mass, double distance) {
    const double moment = 0.05 * mass;
    const auto about = [&] { return AnyAxis(0, 1, moment); };
    const auto along = [&] { return AnyAxis(0, 0.3, mass); };
    const auto maybe = [&](const JointAxis& axis) {
      return random_.Chance(0.5) ? std::optional<JointAxis>(axis) : std::nullopt;
    };
    switch (random_.Below(std::variant_size_v<JointKind>)) {
      case 0:
        return random_.Chance(0.5) ? BallJoint{} : BallJoint{.swing_max = 0.8, .twist = {-0.5, 0.5}};
      case 1:
        return HingeJoint{about()};
      case 2:
        return SliderJoint{along()};
      case 3:
        return UniversalJoint{about(), about()};
      case 4:
        return FixedJoint{};
      case 5:
        return WheelJoint{maybe(along()), maybe(about()), about()};
      case 6:
        return SixDofJoint{{maybe(along()), maybe(along()), maybe(along())},
                           {maybe(about()), maybe(about()), maybe(about())}};
      case 7:
        return DistanceJoint{random_.Chance(0.3) ? JointAxis{} : AnyAxis(distance, 0.5 * distance, mass)};
      default:
        return GearJoint{random_.Uniform(0.5, 3)};
    }
  }

  // Each mover is joined to one before it at most, so that joints never contradict each other.
  void AddJoint(size_t mover) {
    const auto& [id, mass] = movers_[mover];
    const bool to_world = mover == 0 || random_.Chance(0.3);
    const EntityId other = to_world ? EntityId() : movers_[random_.Below(mover)].first;
    const Vector3 from = to_world ? Vector3(Vector3::Zero()) : PositionOf(*scene_.world, other);
    JointDesc joint = Between(other, id, AnyKind(mass, (PositionOf(*scene_.world, id) - from).norm()));
    if (!Can(FeatureOf(joint.kind))) return;
    joint.collide_connected = random_.Chance(0.2);
    if (random_.Chance(0.2)) joint.break_force = mass * random_.Uniform(50, 500);
    if (random_.Chance(0.1)) joint.break_torque = mass * random_.Uniform(50, 500);
    Join(*scene_.world, joint);
  }

  void AddFields() {
    const Region crowd{Vector3::Constant(-kCrowdEnd), Vector3::Constant(kCrowdEnd)};
    const auto add = [&](const ForceFieldKind& kind) {
      ForceField field{.kind = kind};
      if (!std::holds_alternative<SpringField>(kind)) field.region = crowd;
      if (random_.Chance(0.3)) Do(*scene_.world, CreateForceField{field});
    };
    add(UniformField{.force = random_.Vector(0.01), .acceleration = random_.Vector(2)});
    add(DragField{.linear = random_.Uniform(0, 0.1), .quadratic = 0.1, .medium_velocity = random_.Vector(3)});
    add(PointGravityField{.center = random_.Vector(3), .strength = random_.Uniform(-2, 2), .softening = 0.5});
    // Thin, for a cork of a gram that takes the room of a person would leave water faster than any step can follow.
    add(BuoyancyField{.surface_offset = 0.5, .fluid_density = 1, .drag = {.linear = 1}});
    if (movers_.size() < 2) return;
    const double mass = std::min(movers_[0].second, movers_[1].second);
    add(SpringField{
        .a = movers_[0].first, .b = movers_[1].first, .rest_length = 2, .stiffness = mass * 20, .damping = mass});
  }

  void AddForces() {
    for (const auto& [id, mass] : movers_) {
      if (!random_.Chance(0.4)) continue;
      ApplyForce force{.id = id, .force = mass * random_.Vector(5), .torque = mass * random_.Vector(0.02)};
      force.coordinates = random_.Chance(0.5) ? Coordinates::kEntity : Coordinates::kWorld;
      if (random_.Chance(0.5)) {
        force.point = random_.Vector(0.1);
        if (force.coordinates == Coordinates::kWorld) *force.point += PositionOf(*scene_.world, id);
      }
      force.steps = static_cast<uint32_t>(1 + random_.Below(200));
      Do(*scene_.world, force);
    }
  }

  void AddThoseApart() {
    const Shape solid = Can(Feature::kShapeBox) ? Shape{Box{{0.5, 0.5, 0.5}}} : Shape{Sphere{0.5}};
    for (int i = 0; i < 3; ++i) {
      EntityDesc rests = Body(solid, {kApart + 5.0 * i, 0, 0.5}, random_.LogUniform(kMassMin, kMassMax));
      rests.rigid_body->auto_disable = {true, 0.05, 0.1, 0.05};
      scene_.sleepers.push_back(Add(*scene_.world, rests));
    }
    if (Can(Feature::kJointBall)) {
      EntityDesc bob = Ball({-kApart, 1, 10}, 0.2, random_.LogUniform(kMassMin, kMassMax));
      bob.rigid_body->linear_velocity = {1, 0, 0};
      scene_.hook =
          Join(*scene_.world, ToWorld(Add(*scene_.world, bob), BallJoint{}, Pose{{-kApart, 0, 10}, {1, 0, 0, 0}}));
    }
    EntityDesc flyer = Ball({0, kApart, 500}, 0.3, random_.LogUniform(kMassMin, kMassMax));
    flyer.rigid_body->gravity_scale = 0;
    flyer.rigid_body->linear_damping = 0;
    scene_.flyer = Add(*scene_.world, flyer);
    scene_.push = random_.Vector(1);
    scene_.push_steps = static_cast<uint32_t>(20 + random_.Below(150));
    Do(*scene_.world,
       ApplyForce{
           .id = scene_.flyer, .force = *flyer.rigid_body->inertia.mass * scene_.push, .steps = scene_.push_steps});
  }

  const std::vector<std::string> engines_;
  Random random_;
  RandomScene scene_;
  std::vector<std::pair<EntityId, double>> movers_;  // and their masses, kg
};

}  // namespace

RandomScene MakeRandomScene(const std::vector<std::string>& engines, uint64_t seed) {
  return Builder(engines, seed).Build();
}

}  // namespace genphys::testing

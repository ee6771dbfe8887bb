#include "raw_bullet.h"

#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"

namespace genphys::bench {
namespace {

// Of a motor without a bound, N*m: its impulse must stay a number.
constexpr double kForceMax = 1e9;

btVector3 ToBullet(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
btQuaternion ToBullet(const Quaternion& q) { return {q.x(), q.y(), q.z(), q.w()}; }
btTransform ToBullet(const Pose& pose) { return btTransform(ToBullet(pose.orientation), ToBullet(pose.position)); }
Vector3 FromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

// A mesh or heightfield, which Bullet only points to.
struct MeshCopy {
  std::vector<double> points;
  std::vector<int> triangles;
  std::unique_ptr<btTriangleIndexVertexArray> arrays;
};

// A motor, which Bullet wants told anew as the size of steps changes. One that drives to a position is one to a
// velocity that is steered by the error.
struct Driven {
  btHingeConstraint* hinge = nullptr;
  double velocity = 0;
  double force_max = 0;
  double rate = 0;  // 1/s, at which the error is taken away; zero: there is no position
  double position = 0;
};

struct Pushed {
  size_t body = 0;
  Vector3 force;
  Vector3 torque;
};

class ShapeMaker {
 public:
  using Made = std::unique_ptr<btCollisionShape>;

  explicit ShapeMaker(std::vector<std::unique_ptr<MeshCopy>>& meshes) : meshes_(meshes) {}

  Made operator()(const Sphere& s) { return std::make_unique<btSphereShape>(s.radius); }
  Made operator()(const Box& b) { return std::make_unique<btBoxShape>(ToBullet(b.half_extents)); }
  Made operator()(const Capsule& c) { return std::make_unique<btCapsuleShapeZ>(c.radius, 2 * c.half_length); }
  Made operator()(const Cylinder& c) {
    return std::make_unique<btCylinderShapeZ>(btVector3(c.radius, c.radius, c.half_length));
  }
  Made operator()(const Plane& p) { return std::make_unique<btStaticPlaneShape>(ToBullet(p.normal), p.offset); }
  Made operator()(const ConvexHull& hull) {
    auto shape = std::make_unique<btConvexHullShape>();
    for (const Vector3& v : hull.data->vertices) shape->addPoint(ToBullet(v), false);
    shape->recalcLocalAabb();
    return shape;
  }
  Made operator()(const TriangleMesh& mesh) {
    MeshCopy& copy = *meshes_.emplace_back(std::make_unique<MeshCopy>());
    for (const Vector3& v : mesh.data->vertices) copy.points.insert(copy.points.end(), v.begin(), v.end());
    copy.triangles.assign(mesh.data->indices.begin(), mesh.data->indices.end());
    copy.arrays = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(copy.triangles.size() / 3), copy.triangles.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(copy.points.size() / 3), copy.points.data(), static_cast<int>(3 * sizeof(double)));
    return std::make_unique<btBvhTriangleMeshShape>(copy.arrays.get(), true);
  }
  Made operator()(const Heightfield& field) {
    const HeightfieldData& given = *field.data;
    MeshCopy& copy = *meshes_.emplace_back(std::make_unique<MeshCopy>());
    copy.points = given.heights;
    // Its origin is halfway between the lowest and the highest that it is told.
    double most = 0;
    for (const double height : given.heights) most = std::max(most, std::abs(height));
    auto shape = std::make_unique<btHeightfieldTerrainShape>(
        static_cast<int>(given.columns), static_cast<int>(given.rows), copy.points.data(), -most, most, 2, false);
    shape->setLocalScaling(btVector3(given.cell_size, given.cell_size, 1));
    return shape;
  }
  Made operator()(const Cone& c) { return std::make_unique<btConeShapeZ>(c.radius, 2 * c.half_length); }
  Made operator()(const Ellipsoid&) { throw NotHad("ellipsoids"); }

 private:
  std::vector<std::unique_ptr<MeshCopy>>& meshes_;
};

btDefaultCollisionConstructionInfo PoolsOf(const BulletSetup& setup) {
  btDefaultCollisionConstructionInfo info;
  if (setup.pool_size) {
    info.m_defaultMaxPersistentManifoldPoolSize = *setup.pool_size;
    info.m_defaultMaxCollisionAlgorithmPoolSize = *setup.pool_size;
  }
  return info;
}

class RawBullet final : public Simulation {
 public:
  RawBullet(const BulletSetup& setup, const Scene& scene)
      : friction_(scene.friction),
        restitution_(scene.restitution),
        may_sleep_(scene.may_sleep),
        configuration_(PoolsOf(setup)),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    world_.setForceUpdateAllAabbs(setup.updates_all_boxes);
    world_.getDispatchInfo().m_useContinuous = setup.is_continuous;
    world_.getSimulationIslandManager()->setSplitIslands(setup.splits_islands);
    SetGravity(scene.gravity);
    for (const EntityDesc& body : scene.bodies) Add(body);
    if (scene.has_ground) {
      Place(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0), btTransform::getIdentity(), 0, {});
    }
    for (const JointDesc& joint : scene.joints) Join(joint);
  }

  ~RawBullet() override {
    for (const auto& joint : joints_) {
      if (joint) world_.removeConstraint(joint.get());
    }
    for (const auto& body : bodies_) {
      if (body) world_.removeRigidBody(body.get());
    }
  }

  void Step(double step_size) override {
    for (const auto& [joint, driven] : driven_) Steer(driven, step_size);
    for (const Pushed& pushed : pushed_) {
      bodies_[pushed.body]->applyCentralForce(ToBullet(pushed.force));
      bodies_[pushed.body]->applyTorque(ToBullet(pushed.torque));
    }
    world_.stepSimulation(step_size, 0);
  }

  Motion MotionOf(size_t body) const override {
    const btRigidBody& b = *bodies_.at(body);
    const btQuaternion q = b.getOrientation();
    return {FromBullet(b.getCenterOfMassPosition()), Quaternion(q.w(), q.x(), q.y(), q.z()),
            FromBullet(b.getLinearVelocity()), FromBullet(b.getAngularVelocity())};
  }

  void Hold(size_t body, const Vector3& force, const Vector3& torque) override {
    std::erase_if(pushed_, [&](const Pushed& pushed) { return pushed.body == body; });
    pushed_.push_back({body, force, torque});
  }

  void Kick(size_t body, const Vector3& impulse) override {
    bodies_.at(body)->activate();
    bodies_[body]->applyCentralImpulse(ToBullet(impulse));
  }

  void SetGravity(const Vector3& gravity) override {
    world_.setGravity(ToBullet(gravity));
    for (const auto& body : bodies_) {
      if (body && body->getInvMass() > 0) body->setGravity(ToBullet(gravity));
    }
  }

  void Remove(size_t body) override {
    world_.removeRigidBody(bodies_.at(body).get());
    bodies_[body].reset();
  }

  void Release(size_t joint) override {
    driven_.erase(joint);
    world_.removeConstraint(joints_.at(joint).get());
    joints_[joint].reset();
  }

  void Aim(std::span<const size_t> joints, std::span<const double> positions,
           std::span<const double> velocities) override {
    for (size_t i = 0; i < joints.size(); ++i) {
      Driven& driven = driven_.at(joints[i]);
      driven.position = positions[i];
      driven.velocity = velocities[i];
    }
  }

  StepStats Explain(double step_size) override {
    Step(step_size);
    StepStats stats;
    for (const auto& body : bodies_) {
      if (body == nullptr || body->getInvMass() == 0) continue;
      ++(body->isActive() ? stats.entities_in_engine : stats.entities_asleep);
    }
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const int points = dispatcher_.getManifoldByIndexInternal(i)->getNumContacts();
      stats.pairs += points > 0 ? 1 : 0;
      stats.contacts += static_cast<uint32_t>(points);
    }
    return stats;
  }

 private:
  btRigidBody& Place(std::unique_ptr<btCollisionShape> shape, const btTransform& pose, double mass,
                     const btVector3& inertia) {
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.get(), inertia);
    info.m_startWorldTransform = pose;
    // Bullet multiplies the coefficients of both bodies.
    info.m_friction = std::sqrt(friction_);
    info.m_restitution = std::sqrt(restitution_);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    shapes_.push_back(std::move(shape));
    if (!may_sleep_) bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get());
    return *bodies_.back();
  }

  void Add(const EntityDesc& desc) {
    std::unique_ptr<btCollisionShape> shape = ShapeOf(*desc.rigid_body);
    if (desc.rigid_body->motion_type == MotionType::kStatic) {
      Place(std::move(shape), ToBullet(desc.pose), 0, {});
      return;
    }
    const MassProperties mass = MassOf(desc);
    btRigidBody& body =
        Place(std::move(shape), ToBullet(desc.pose), mass.mass, ToBullet(Vector3(mass.tensor.diagonal())));
    body.setLinearVelocity(ToBullet(desc.rigid_body->linear_velocity));
    body.setAngularVelocity(ToBullet(desc.rigid_body->angular_velocity));
  }

  std::unique_ptr<btCollisionShape> ShapeOf(const RigidBody& body) {
    const std::vector<Geometry>& geometries = body.geometries;
    for (const Geometry& geometry : geometries) {
      if (!geometry.surface_velocity.isZero(0)) throw NotHad("surfaces that run");
    }
    if (geometries.size() == 1 && geometries[0].pose_in_entity == Pose{}) {
      return std::visit(ShapeMaker(meshes_), geometries[0].shape);
    }
    auto compound = std::make_unique<btCompoundShape>();
    for (const Geometry& geometry : geometries) {
      shapes_.push_back(std::visit(ShapeMaker(meshes_), geometry.shape));
      compound->addChildShape(ToBullet(geometry.pose_in_entity), shapes_.back().get());
    }
    return compound;
  }

  // The joint that is added next.
  std::unique_ptr<btTypedConstraint> Hinge(std::unique_ptr<btHingeConstraint> hinge, const JointAxis& axis) {
    if (axis.spring) throw NotHad("springs in joints");
    if (axis.limits.lower.has_value() != axis.limits.upper.has_value()) throw NotHad("limits on one side");
    // It counts its angle the other way round.
    if (axis.limits.lower) hinge->setLimit(-*axis.limits.upper, -*axis.limits.lower);
    if (axis.motor) {
      const Motor& motor = *axis.motor;
      Driven& driven = driven_[joints_.size()];
      driven = {
          .hinge = hinge.get(), .velocity = motor.target_velocity, .force_max = motor.force_max.value_or(kForceMax)};
      if (motor.target_position) {
        driven.rate = motor.stiffness / motor.damping;
        driven.position = *motor.target_position;
      }
    }
    return hinge;
  }

  static void Steer(const Driven& driven, double step_size) {
    double velocity = driven.velocity;
    // No faster than in one step.
    if (driven.rate > 0) {
      velocity += std::min(driven.rate, 1 / step_size) * (driven.position + driven.hinge->getHingeAngle());
    }
    driven.hinge->enableAngularMotor(true, -velocity, driven.force_max * step_size);
  }

  void Join(const JointDesc& desc) {
    btRigidBody& b = *bodies_.at(*PlaceOf(desc.entity_b));
    btRigidBody& a =
        desc.entity_a.is_world() ? btTypedConstraint::getFixedBody() : *bodies_.at(*PlaceOf(desc.entity_a));
    const btTransform in_a = ToBullet(*desc.frame_in_a);
    const btTransform in_b = ToBullet(*desc.frame_in_b);
    std::unique_ptr<btTypedConstraint> joint;
    // What is x of its frames is z of ours.
    const btTransform turn(btQuaternion(btVector3(0, 1, 0), -SIMD_HALF_PI), btVector3(0, 0, 0));
    const auto* ball = std::get_if<BallJoint>(&desc.kind);
    if (ball != nullptr && !IsPlain(desc.kind)) {
      auto cone = std::make_unique<btConeTwistConstraint>(a, b, in_a * turn, in_b * turn);
      // It has one bound for both ways to twist.
      const double swing = ball->swing_max.value_or(SIMD_PI);
      cone->setLimit(swing, swing, ball->twist.upper.value_or(SIMD_PI));
      joint = std::move(cone);
    } else if (ball != nullptr) {
      joint = std::make_unique<btPoint2PointConstraint>(a, b, in_a.getOrigin(), in_b.getOrigin());
    } else if (const auto* hinge = std::get_if<HingeJoint>(&desc.kind)) {
      joint = Hinge(std::make_unique<btHingeConstraint>(a, b, in_a, in_b), hinge->axis);
    } else if (std::holds_alternative<SliderJoint>(desc.kind) && IsPlain(desc.kind)) {
      joint = std::make_unique<btSliderConstraint>(a, b, in_a * turn, in_b * turn, true);
    } else {
      throw NotHad("this kind of joint");
    }
    world_.addConstraint(joint.get(), true);
    joints_.push_back(std::move(joint));
  }

  double friction_;
  double restitution_;
  bool may_sleep_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::vector<std::unique_ptr<MeshCopy>> meshes_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  std::map<size_t, Driven> driven_;  // by joint
  std::vector<Pushed> pushed_;
  btDiscreteDynamicsWorld world_;
};

}  // namespace

std::unique_ptr<Simulation> SimulateInRawBullet(const BulletSetup& setup, const Scene& scene) {
  return std::make_unique<RawBullet>(setup, scene);
}

}  // namespace genphys::bench

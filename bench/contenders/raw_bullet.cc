#include "raw_bullet.h"

#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"

namespace genphys::bench {
namespace {

btVector3 ToBullet(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
btQuaternion ToBullet(const Quaternion& q) { return {q.x(), q.y(), q.z(), q.w()}; }
btTransform ToBullet(const Pose& pose) { return btTransform(ToBullet(pose.orientation), ToBullet(pose.position)); }
Vector3 FromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

// A mesh, which Bullet only points to.
struct MeshCopy {
  std::vector<double> points;
  std::vector<int> triangles;
  std::unique_ptr<btTriangleIndexVertexArray> arrays;
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
  template <typename Other>
  Made operator()(const Other&) {
    throw std::logic_error("no problem has this shape");
  }

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
    world_.removeConstraint(joints_.at(joint).get());
    joints_[joint].reset();
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
    std::unique_ptr<btCollisionShape> shape = std::visit(ShapeMaker(meshes_), desc.rigid_body->geometries.at(0).shape);
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

  void Join(const JointDesc& desc) {
    btRigidBody& b = *bodies_.at(*PlaceOf(desc.entity_b));
    btRigidBody& a =
        desc.entity_a.is_world() ? btTypedConstraint::getFixedBody() : *bodies_.at(*PlaceOf(desc.entity_a));
    const btTransform in_a = ToBullet(*desc.frame_in_a);
    const btTransform in_b = ToBullet(*desc.frame_in_b);
    std::unique_ptr<btTypedConstraint> joint;
    if (!IsPlain(desc.kind)) throw std::logic_error("an engine alone has no springs, motors and limits here");
    if (std::holds_alternative<BallJoint>(desc.kind)) {
      joint = std::make_unique<btPoint2PointConstraint>(a, b, in_a.getOrigin(), in_b.getOrigin());
    } else if (std::holds_alternative<HingeJoint>(desc.kind)) {
      joint = std::make_unique<btHingeConstraint>(a, b, in_a, in_b);
    } else if (std::holds_alternative<SliderJoint>(desc.kind)) {
      // It slides along x of its frames, ours along z.
      const btTransform turn(btQuaternion(btVector3(0, 1, 0), -SIMD_HALF_PI), btVector3(0, 0, 0));
      joint = std::make_unique<btSliderConstraint>(a, b, in_a * turn, in_b * turn, true);
    } else {
      throw std::logic_error("no problem has this joint");
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
  std::vector<Pushed> pushed_;
  btDiscreteDynamicsWorld world_;
};

}  // namespace

std::unique_ptr<Simulation> SimulateInRawBullet(const BulletSetup& setup, const Scene& scene) {
  return std::make_unique<RawBullet>(setup, scene);
}

}  // namespace genphys::bench

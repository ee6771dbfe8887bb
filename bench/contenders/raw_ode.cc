#include "raw_ode.h"

#include <ode/ode.h>

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"

namespace genphys::bench {
namespace {

constexpr int kContactsMax = 8;    // of a pair, in any setup
constexpr double kFieldDepth = 1;  // m, below the lowest height: what is solid

// A hull, mesh or heightfield, which ODE only points to.
struct ShapeData {
  std::vector<dReal> planes;
  std::vector<dReal> points;
  std::vector<unsigned> polygons;
  std::vector<dTriIndex> triangles;
  dHeightfieldDataID field = nullptr;

  ShapeData() = default;
  ShapeData(const ShapeData&) = delete;
  ShapeData& operator=(const ShapeData&) = delete;
  ~ShapeData() {
    if (field != nullptr) dGeomHeightfieldDataDestroy(field);
  }
};

// What stands in place of a motor that drives to a position: one to a velocity that is steered by the error.
struct Servo {
  double rate = 0;  // 1/s, at which the error is taken away
  double position = 0;
  double velocity = 0;
};

// A joint as ODE has it.
struct Joined {
  dJointID joint = nullptr;
  dJointID limits = nullptr;  // of a ball: a joint of its own
  double sign = 1;            // of its angle beside ours
  std::optional<Servo> servo;
};

struct Pushed {
  size_t body = 0;
  Vector3 force;
  Vector3 torque;
};

class GeomMaker {
 public:
  GeomMaker(dSpaceID space, std::vector<std::unique_ptr<ShapeData>>& data) : space_(space), data_(data) {}

  dGeomID operator()(const Sphere& s) { return dCreateSphere(space_, s.radius); }
  dGeomID operator()(const Box& b) {
    return dCreateBox(space_, 2 * b.half_extents.x(), 2 * b.half_extents.y(), 2 * b.half_extents.z());
  }
  dGeomID operator()(const Capsule& c) { return dCreateCapsule(space_, c.radius, 2 * c.half_length); }
  dGeomID operator()(const Cylinder& c) { return dCreateCylinder(space_, c.radius, 2 * c.half_length); }
  dGeomID operator()(const Plane& p) {
    return dCreatePlane(space_, p.normal.x(), p.normal.y(), p.normal.z(), p.offset);
  }
  dGeomID operator()(const ConvexHull& hull) {
    ShapeData& data = *data_.emplace_back(std::make_unique<ShapeData>());
    for (const HullData::Face& face : hull.data->faces) {
      data.planes.insert(data.planes.end(), {face.normal.x(), face.normal.y(), face.normal.z(), face.offset});
      data.polygons.push_back(face.count);
      for (const uint32_t corner : hull.data->CornersOf(face)) data.polygons.push_back(corner);
    }
    for (const Vector3& v : hull.data->vertices) data.points.insert(data.points.end(), v.begin(), v.end());
    return dCreateConvex(space_, data.planes.data(), static_cast<unsigned>(hull.data->faces.size()), data.points.data(),
                         static_cast<unsigned>(hull.data->vertices.size()), data.polygons.data());
  }
  dGeomID operator()(const TriangleMesh& mesh) {
    ShapeData& data = *data_.emplace_back(std::make_unique<ShapeData>());
    for (const Vector3& v : mesh.data->vertices) data.points.insert(data.points.end(), v.begin(), v.end());
    data.triangles.assign(mesh.data->indices.begin(), mesh.data->indices.end());
    const dTriMeshDataID made = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(made, data.points.data(), 3 * sizeof(dReal), static_cast<int>(data.points.size() / 3),
                                data.triangles.data(), static_cast<int>(data.triangles.size()), 3 * sizeof(dTriIndex));
    return dCreateTriMesh(space_, made, nullptr, nullptr, nullptr);
  }
  dGeomID operator()(const Heightfield& field) {
    const HeightfieldData& given = *field.data;
    ShapeData& data = *data_.emplace_back(std::make_unique<ShapeData>());
    // Its rows go the other way: it has y up, and is turned by its pose.
    for (uint32_t row = given.rows; row-- > 0;) {
      const auto begin = given.heights.begin() + static_cast<ptrdiff_t>(size_t{row} * given.columns);
      data.points.insert(data.points.end(), begin, begin + given.columns);
    }
    const dHeightfieldDataID made = data.field = dGeomHeightfieldDataCreate();
    dGeomHeightfieldDataBuildDouble(made, data.points.data(), 0, (given.columns - 1) * given.cell_size,
                                    (given.rows - 1) * given.cell_size, static_cast<int>(given.columns),
                                    static_cast<int>(given.rows), 1, 0, kFieldDepth, 0);
    return dCreateHeightfield(space_, made, 1);
  }
  dGeomID operator()(const Cone&) { throw NotHad("cones"); }
  dGeomID operator()(const Ellipsoid&) { throw NotHad("ellipsoids"); }

 private:
  dSpaceID space_;
  std::vector<std::unique_ptr<ShapeData>>& data_;
};

dSpaceID MakeSpace(OdeSpace space) {
  switch (space) {
    case OdeSpace::kSweepXyz:
      return dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
    case OdeSpace::kSweepXzy:
      return dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XZY);
    case OdeSpace::kHash:
      return dHashSpaceCreate(nullptr);
  }
  throw std::logic_error("no such space");
}

class RawOde final : public Simulation {
 public:
  // In two parts, so that a world that cannot be filled is taken down.
  RawOde(const OdeSetup& setup, const Scene& scene) : RawOde(setup, scene.friction, scene.restitution) {
    SetGravity(scene.gravity);
    dWorldSetAutoDisableFlag(world_, scene.may_sleep ? 1 : 0);
    if (scene.has_ground) dCreatePlane(space_, 0, 0, 1, 0);
    for (const EntityDesc& body : scene.bodies) Add(body);
    for (const JointDesc& joint : scene.joints) Join(joint);
  }

  RawOde(const OdeSetup& setup, double friction, double restitution)
      : setup_(setup), friction_(friction), restitution_(restitution) {
    if (setup.contacts_max > kContactsMax) throw std::logic_error("too many contacts of a pair");
    dInitODE2(0);
    world_ = dWorldCreate();
    space_ = MakeSpace(setup.space);
    contacts_ = dJointGroupCreate(0);
  }

  ~RawOde() override {
    dJointGroupDestroy(contacts_);
    dWorldDestroy(world_);
    dSpaceDestroy(space_);
    dCloseODE();
  }

  void Step(double step_size) override {
    // The sweeps take the rows in random order: the same one in every run, whoever else takes steps in between.
    dRandSetSeed(seed_);
    for (const Joined& joined : joints_) Steer(joined, step_size);
    dSpaceCollide(space_, this, &RawOde::Near);
    for (const Pushed& pushed : pushed_) {
      dBodyAddForce(bodies_[pushed.body], pushed.force.x(), pushed.force.y(), pushed.force.z());
      dBodyAddTorque(bodies_[pushed.body], pushed.torque.x(), pushed.torque.y(), pushed.torque.z());
    }
    if (setup_.stepper == OdeStepper::kWorldStep) {
      dWorldStep(world_, step_size);
    } else {
      dWorldQuickStep(world_, step_size);
    }
    dJointGroupEmpty(contacts_);
    seed_ = dRandGetSeed();
  }

  Motion MotionOf(size_t body) const override {
    const dBodyID b = bodies_.at(body);
    const dReal* q = dBodyGetQuaternion(b);
    return {Vector3(dBodyGetPosition(b)), Quaternion(q[0], q[1], q[2], q[3]), Vector3(dBodyGetLinearVel(b)),
            Vector3(dBodyGetAngularVel(b))};
  }

  void Hold(size_t body, const Vector3& force, const Vector3& torque) override {
    std::erase_if(pushed_, [&](const Pushed& pushed) { return pushed.body == body; });
    pushed_.push_back({body, force, torque});
  }

  void Kick(size_t body, const Vector3& impulse) override {
    const dBodyID b = bodies_.at(body);
    dMass mass;
    dBodyGetMass(b, &mass);
    const Vector3 v = Vector3(dBodyGetLinearVel(b)) + impulse / mass.mass;
    dBodyEnable(b);
    dBodySetLinearVel(b, v.x(), v.y(), v.z());
  }

  void SetGravity(const Vector3& gravity) override { dWorldSetGravity(world_, gravity.x(), gravity.y(), gravity.z()); }

  void Remove(size_t body) override {
    for (const dGeomID geom : geoms_.at(body)) dGeomDestroy(geom);
    geoms_[body].clear();
    if (bodies_[body] != nullptr) dBodyDestroy(bodies_[body]);
  }

  void Release(size_t joint) override {
    const Joined gone = std::exchange(joints_.at(joint), {});
    if (gone.limits != nullptr) dJointDestroy(gone.limits);
    dJointDestroy(gone.joint);
  }

  void Aim(std::span<const size_t> joints, std::span<const double> positions,
           std::span<const double> velocities) override {
    for (size_t i = 0; i < joints.size(); ++i) {
      Servo& servo = joints_.at(joints[i]).servo.value();
      servo.position = positions[i];
      servo.velocity = velocities[i];
    }
  }

  StepStats Explain(double step_size) override {
    stats_ = {};
    Step(step_size);
    for (const dBodyID body : bodies_) {
      if (body != nullptr) ++(dBodyIsEnabled(body) != 0 ? stats_.entities_in_engine : stats_.entities_asleep);
    }
    return stats_;
  }

 private:
  static void Near(void* self, dGeomID a, dGeomID b) { static_cast<RawOde*>(self)->Touch(a, b); }

  void Touch(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a);
    const dBodyID body_b = dGeomGetBody(b);
    // Both static, or parts of one body.
    if (body_a == body_b) return;
    if (body_a != nullptr && body_b != nullptr && dAreConnectedExcluding(body_a, body_b, dJointTypeContact) != 0)
      return;
    std::array<dContact, kContactsMax> contacts{};
    const int count = dCollide(a, b, setup_.contacts_max, &contacts[0].geom, sizeof(dContact));
    stats_.pairs += count > 0 ? 1 : 0;
    stats_.contacts += static_cast<uint32_t>(count);
    for (int i = 0; i < count; ++i) {
      dSurfaceParameters& surface = contacts[i].surface;
      surface.mode = dContactApprox1;
      surface.mu = friction_;
      if (restitution_ > 0) {
        surface.mode |= dContactBounce;
        surface.bounce = restitution_;
      }
      if (!belts_.empty()) LetRun(contacts[i], a, b);
      dJointAttach(dJointCreateContact(world_, contacts_, &contacts[i]), body_a, body_b);
    }
  }

  void Add(const EntityDesc& desc) {
    const Vector3& p = desc.pose.position;
    const dQuaternion q = {desc.pose.orientation.w(), desc.pose.orientation.x(), desc.pose.orientation.y(),
                           desc.pose.orientation.z()};
    const std::vector<Geometry>& geometries = desc.rigid_body->geometries;
    std::vector<dGeomID>& geoms = geoms_.emplace_back();
    for (const Geometry& geometry : geometries) {
      geoms.push_back(std::visit(GeomMaker(space_, data_), geometry.shape));
      if (!geometry.surface_velocity.isZero(0)) belts_[geoms.back()] = geometry.surface_velocity;
    }
    bodies_.push_back(nullptr);
    if (desc.rigid_body->motion_type == MotionType::kStatic) {
      PlaceStatic(geoms.at(0), desc.pose);
      return;
    }
    const dBodyID body = bodies_.back() = dBodyCreate(world_);
    for (size_t i = 0; i < geoms.size(); ++i) {
      dGeomSetBody(geoms[i], body);
      const Pose& part = geometries[i].pose_in_entity;
      if (part == Pose{}) continue;
      dGeomSetOffsetPosition(geoms[i], part.position.x(), part.position.y(), part.position.z());
      const Quaternion& turn = part.orientation;
      const dQuaternion t = {turn.w(), turn.x(), turn.y(), turn.z()};
      dGeomSetOffsetQuaternion(geoms[i], t);
    }
    const MassProperties properties = MassOf(desc);
    const Matrix3& tensor = properties.tensor;
    dMass mass;
    dMassSetParameters(&mass, properties.mass, 0, 0, 0, tensor(0, 0), tensor(1, 1), tensor(2, 2), tensor(0, 1),
                       tensor(0, 2), tensor(1, 2));
    dBodySetMass(body, &mass);
    dBodySetPosition(body, p.x(), p.y(), p.z());
    dBodySetQuaternion(body, q);
    const Vector3& v = desc.rigid_body->linear_velocity;
    const Vector3& w = desc.rigid_body->angular_velocity;
    dBodySetLinearVel(body, v.x(), v.y(), v.z());
    dBodySetAngularVel(body, w.x(), w.y(), w.z());
  }

  static void PlaceStatic(dGeomID geom, const Pose& pose) {
    if (dGeomGetClass(geom) == dPlaneClass) return;
    const Vector3& p = pose.position;
    Quaternion turn = pose.orientation;
    if (dGeomGetClass(geom) == dHeightfieldClass) turn = turn * Turn(std::numbers::pi / 2, Vector3::UnitX());
    const dQuaternion q = {turn.w(), turn.x(), turn.y(), turn.z()};
    dGeomSetPosition(geom, p.x(), p.y(), p.z());
    dGeomSetQuaternion(geom, q);
  }

  // A surface that runs drags what lies on it along.
  void LetRun(dContact& contact, dGeomID a, dGeomID b) const {
    const auto belt = belts_.contains(a) ? belts_.find(a) : belts_.find(b);
    if (belt == belts_.end()) return;
    const Vector3 normal(contact.geom.normal);
    const Vector3 along = belt->second - normal.dot(belt->second) * normal;
    if (along.norm() < 1e-6) return;
    const Vector3 direction = along.normalized();
    contact.surface.mode |= dContactMotion1 | dContactFDir1;
    contact.surface.motion1 = along.norm();
    for (int i = 0; i < 3; ++i) contact.fdir1[i] = direction[i];
  }

  static void Steer(const Joined& joined, double step_size) {
    if (!joined.servo) return;
    const Servo& servo = *joined.servo;
    // No faster than in one step.
    const double rate = std::min(servo.rate, 1 / step_size);
    const double angle = joined.sign * dJointGetHingeAngle(joined.joint);
    dJointSetHingeParam(joined.joint, dParamVel, servo.velocity + rate * (servo.position - angle));
  }

  static void Drive(const JointAxis& axis, Joined& joined) {
    if (axis.spring) throw NotHad("springs in joints");
    if (axis.limits.lower) dJointSetHingeParam(joined.joint, dParamLoStop, *axis.limits.lower);
    if (axis.limits.upper) dJointSetHingeParam(joined.joint, dParamHiStop, *axis.limits.upper);
    if (!axis.motor) return;
    const Motor& motor = *axis.motor;
    dJointSetHingeParam(joined.joint, dParamVel, motor.target_velocity);
    dJointSetHingeParam(joined.joint, dParamFMax, motor.force_max.value_or(dInfinity));
    if (motor.target_position) {
      joined.servo = Servo{motor.stiffness / motor.damping, *motor.target_position, motor.target_velocity};
    }
  }

  // Three angles in place of a cone: what it has.
  dJointID LimitBall(const BallJoint& ball, dBodyID a, dBodyID b, const Quaternion& frame) {
    // It does not turn farther about the second of its axes.
    constexpr double kMiddleMax = 1.5;
    const dJointID motor = dJointCreateAMotor(world_, nullptr);
    dJointAttach(motor, a, b);
    dJointSetAMotorMode(motor, dAMotorEuler);
    const Vector3 z = frame * Vector3::UnitZ(), x = frame * Vector3::UnitX();
    dJointSetAMotorAxis(motor, 0, 1, z.x(), z.y(), z.z());
    dJointSetAMotorAxis(motor, 2, 2, x.x(), x.y(), x.z());
    const double swing = std::min(ball.swing_max.value_or(kMiddleMax), kMiddleMax);
    dJointSetAMotorParam(motor, dParamLoStop1, ball.twist.lower.value_or(-dInfinity));
    dJointSetAMotorParam(motor, dParamHiStop1, ball.twist.upper.value_or(dInfinity));
    dJointSetAMotorParam(motor, dParamLoStop2, -swing);
    dJointSetAMotorParam(motor, dParamHiStop2, swing);
    dJointSetAMotorParam(motor, dParamLoStop3, -swing);
    dJointSetAMotorParam(motor, dParamHiStop3, swing);
    return motor;
  }

  void Join(const JointDesc& desc) {
    const size_t place_b = *PlaceOf(desc.entity_b);
    const dBodyID b = bodies_.at(place_b);
    const dBodyID a = desc.entity_a.is_world() ? nullptr : bodies_.at(*PlaceOf(desc.entity_a));
    const Motion now = MotionOf(place_b);
    const Pose frame = Pose{now.position, now.orientation}.Transform(*desc.frame_in_b);
    const Vector3& p = frame.position;
    const Vector3 axis = frame.orientation * Vector3::UnitZ();
    Joined joined;
    dJointID& joint = joined.joint;
    if (const auto* ball = std::get_if<BallJoint>(&desc.kind)) {
      joint = dJointCreateBall(world_, nullptr);
      dJointAttach(joint, a, b);
      dJointSetBallAnchor(joint, p.x(), p.y(), p.z());
      if (!IsPlain(desc.kind)) joined.limits = LimitBall(*ball, a, b, frame.orientation);
    } else if (const auto* hinge = std::get_if<HingeJoint>(&desc.kind)) {
      joint = dJointCreateHinge(world_, nullptr);
      dJointAttach(joint, a, b);
      dJointSetHingeAnchor(joint, p.x(), p.y(), p.z());
      // Its angle is that of the first body beside the second; of a body that hangs on the world it is that body's, but
      // is told with the other sign.
      const bool turns = !IsPlain(desc.kind) && a != nullptr;
      const Vector3 its_axis = turns ? Vector3(-axis) : axis;
      dJointSetHingeAxis(joint, its_axis.x(), its_axis.y(), its_axis.z());
      joined.sign = a == nullptr ? -1 : 1;
      Drive(hinge->axis, joined);
    } else if (std::holds_alternative<SliderJoint>(desc.kind) && IsPlain(desc.kind)) {
      joint = dJointCreateSlider(world_, nullptr);
      dJointAttach(joint, a, b);
      dJointSetSliderAxis(joint, axis.x(), axis.y(), axis.z());
    } else {
      throw NotHad("this kind of joint");
    }
    joints_.push_back(joined);
  }

  OdeSetup setup_;
  double friction_;
  double restitution_;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  std::vector<std::unique_ptr<ShapeData>> data_;
  std::vector<std::vector<dGeomID>> geoms_;  // by body
  std::map<dGeomID, Vector3> belts_;         // velocity of surfaces that run, m/s
  std::vector<dBodyID> bodies_;              // null: static
  std::vector<Joined> joints_;
  unsigned long seed_ = 1;  // NOLINT(google-runtime-int): as ODE has it
  std::vector<Pushed> pushed_;
  StepStats stats_;  // pairs and contacts since the last Explain() began
};

}  // namespace

std::unique_ptr<Simulation> SimulateInRawOde(const OdeSetup& setup, const Scene& scene) {
  return std::make_unique<RawOde>(setup, scene);
}

}  // namespace genphys::bench

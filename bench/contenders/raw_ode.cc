#include "raw_ode.h"

#include <ode/ode.h>

#include <array>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"

namespace genphys::bench {
namespace {

constexpr int kContactsMax = 8;  // of a pair, in any setup

// A hull or mesh, which ODE only points to.
struct ShapeData {
  std::vector<dReal> planes;
  std::vector<dReal> points;
  std::vector<unsigned> polygons;
  std::vector<dTriIndex> triangles;
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
  template <typename Other>
  dGeomID operator()(const Other&) {
    throw std::logic_error("no problem has this shape");
  }

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
  RawOde(const OdeSetup& setup, const Scene& scene)
      : setup_(setup), friction_(scene.friction), restitution_(scene.restitution) {
    if (setup.contacts_max > kContactsMax) throw std::logic_error("too many contacts of a pair");
    dInitODE2(0);
    // The sweeps take the rows in random order: the same one in every run.
    dRandSetSeed(1);
    world_ = dWorldCreate();
    space_ = MakeSpace(setup.space);
    contacts_ = dJointGroupCreate(0);
    SetGravity(scene.gravity);
    dWorldSetAutoDisableFlag(world_, scene.may_sleep ? 1 : 0);
    if (scene.has_ground) dCreatePlane(space_, 0, 0, 1, 0);
    for (const EntityDesc& body : scene.bodies) Add(body);
    for (const JointDesc& joint : scene.joints) Join(joint);
  }

  ~RawOde() override {
    dJointGroupDestroy(contacts_);
    dWorldDestroy(world_);
    dSpaceDestroy(space_);
    dCloseODE();
  }

  void Step(double step_size) override {
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
    dGeomDestroy(geoms_.at(body));
    if (bodies_[body] != nullptr) dBodyDestroy(bodies_[body]);
  }

  void Release(size_t joint) override { dJointDestroy(joints_.at(joint)); }

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
    if (body_a == nullptr && body_b == nullptr) return;
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
      dJointAttach(dJointCreateContact(world_, contacts_, &contacts[i]), body_a, body_b);
    }
  }

  void Add(const EntityDesc& desc) {
    const Vector3& p = desc.pose.position;
    const dQuaternion q = {desc.pose.orientation.w(), desc.pose.orientation.x(), desc.pose.orientation.y(),
                           desc.pose.orientation.z()};
    const dGeomID geom = std::visit(GeomMaker(space_, data_), desc.rigid_body->geometries.at(0).shape);
    geoms_.push_back(geom);
    bodies_.push_back(nullptr);
    if (desc.rigid_body->motion_type == MotionType::kStatic) {
      if (dGeomGetClass(geom) == dPlaneClass) return;
      dGeomSetPosition(geom, p.x(), p.y(), p.z());
      dGeomSetQuaternion(geom, q);
      return;
    }
    const dBodyID body = bodies_.back() = dBodyCreate(world_);
    dGeomSetBody(geom, body);
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

  void Join(const JointDesc& desc) {
    const size_t place_b = *PlaceOf(desc.entity_b);
    const dBodyID b = bodies_.at(place_b);
    const dBodyID a = desc.entity_a.is_world() ? nullptr : bodies_.at(*PlaceOf(desc.entity_a));
    const Motion now = MotionOf(place_b);
    const Pose frame = Pose{now.position, now.orientation}.Transform(*desc.frame_in_b);
    const Vector3& p = frame.position;
    const Vector3 axis = frame.orientation * Vector3::UnitZ();
    dJointID joint = nullptr;
    if (!IsPlain(desc.kind)) throw std::logic_error("an engine alone has no springs, motors and limits here");
    if (std::holds_alternative<BallJoint>(desc.kind)) {
      joint = dJointCreateBall(world_, nullptr);
      dJointAttach(joint, a, b);
      dJointSetBallAnchor(joint, p.x(), p.y(), p.z());
    } else if (std::holds_alternative<HingeJoint>(desc.kind)) {
      joint = dJointCreateHinge(world_, nullptr);
      dJointAttach(joint, a, b);
      dJointSetHingeAnchor(joint, p.x(), p.y(), p.z());
      dJointSetHingeAxis(joint, axis.x(), axis.y(), axis.z());
    } else if (std::holds_alternative<SliderJoint>(desc.kind)) {
      joint = dJointCreateSlider(world_, nullptr);
      dJointAttach(joint, a, b);
      dJointSetSliderAxis(joint, axis.x(), axis.y(), axis.z());
    } else {
      throw std::logic_error("no problem has this joint");
    }
    joints_.push_back(joint);
  }

  OdeSetup setup_;
  double friction_;
  double restitution_;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  std::vector<std::unique_ptr<ShapeData>> data_;
  std::vector<dGeomID> geoms_;
  std::vector<dBodyID> bodies_;  // null: static
  std::vector<dJointID> joints_;
  std::vector<Pushed> pushed_;
  StepStats stats_;  // pairs and contacts since the last Explain() began
};

}  // namespace

std::unique_ptr<Simulation> SimulateInRawOde(const OdeSetup& setup, const Scene& scene) {
  return std::make_unique<RawOde>(setup, scene);
}

}  // namespace genphys::bench

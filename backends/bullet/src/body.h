#pragma once
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <memory>
#include <vector>

#include "genphys/backend.h"
#include "genphys/contact_sweeps.h"
#include "genphys/placement.h"

namespace genphys::bullet_backend {

struct Body;

/// One geometry where it now is. It never changes its address, for others point to it.
struct PlacedGeometry {
  Body* body = nullptr;
  GeometryRow row{};
  uint32_t id = 0;  // unique in its body
  Pose pose_in_entity;
  Shape shape;
  Placement placement;
};

/// One entity's body.
struct Body {
  EntityRow row{};
  EntityId id;
  MotionType motion_type = MotionType::kStatic;
  bool is_active = true;
  bool is_moved = false;      // its geometries are not yet where its pose says
  uint64_t solve_stamp = 0;   // of the last solve that moved it
  uint64_t touch_stamp = 0;   // of the last solve that held it by a contact or a joint
  uint64_t island_stamp = 0;  // of the last island that it was solved in
  Pose pose;
  Vector3 center_of_mass = Vector3::Zero();      // in the entity's frame
  Vector3 moments = Vector3::Zero();             // principal ones, kg*m^2
  Matrix3 principal_axes = Matrix3::Identity();  // in the entity's frame, as columns
  double inertia_factor = 1;                     // for the next solve
  std::unique_ptr<btRigidBody> rigid;            // as the solver sees it; none for static bodies
  SweptBody solved;                              // what it made of it
  std::vector<PlacedGeometry> geometries;

  Body(const BodyDesc& desc, const StateArrays& state);
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  bool is_moving() const { return is_active && motion_type != MotionType::kStatic; }

  /// Takes over the pose of its row. Throws EngineFault if it is not finite.
  void TakePose(const StateArrays& state);

  /// Brings its geometries to its pose.
  void PlaceGeometries();

  /// Gives the solver pose and velocity of its row.
  void LoadRigid(const StateArrays& state);
};

}  // namespace genphys::bullet_backend

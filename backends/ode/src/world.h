#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "broad_phase.h"
#include "contact_solver.h"
#include "genphys/backend.h"
#include "shapes.h"

namespace genphys::ode_backend {

/// A world on ODE. The library's collision pairs and solver are used, and none of its spaces: what it gives depends on
/// the columns, the seed and the active set alone, not on how these came about.
class World final : public BackendWorld {
 public:
  explicit World(const StepperSettings& settings) : solver_(settings) {}

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override;
  void SetActive(std::span<const EntityRow> rows, bool active) override;
  void WriteState(std::span<const EntityRow> rows, const StateArrays& state) override;
  void SetStepper(const StepperSettings& settings) override { solver_.SetStepper(settings); }
  void Collide(const PairRule& rule, ContactBuffer& contacts) override;
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts) override;
  void CastRays(const PairRule& rule, std::span<const Ray> rays, uint64_t collides_with_bits,
                std::span<RayHit> hits) override;
  void SaveState(std::string& bytes) const override;

 private:
  static constexpr uint32_t kUnsolved = ContactConstraint::kImmovable;

  struct Body {
    EntityId id;          // null: none in this row
    uint64_t serial = 0;  // of the call that added it
    MotionType motion_type = MotionType::kStatic;
    bool is_active = false;
    bool is_centered = true;         // the centre of mass is the origin of the entity's frame
    uint32_t solved_as = kUnsolved;  // place in the solver, during a solve
    MassProperties mass;
    std::vector<GeometryRow> geometries;
  };

  struct Candidate {
    EntityId id_a;  // the smaller
    EntityId id_b;
    GeometryRow a{};
    GeometryRow b{};
    bool is_sensor = false;
  };

  // A contact's side as the solver needs it.
  struct Side {
    uint32_t solved_as = kUnsolved;
    Vector3 velocity = Vector3::Zero();  // at the point, m/s
  };

  const Body& body_of(GeometryRow row) const { return bodies_[Index(shapes_[Index(row)].entity())]; }
  void Place(const Body& body, const Vector3& position, const Quaternion& orientation);
  Motion MotionOf(EntityRow row, const StateArrays& state) const;
  void AddCandidate(const PairRule& rule, GeometryRow a, GeometryRow b);
  void PutInOrder(const PairRule& rule);
  void LoadBodies(std::span<const EntityRow> rows, const StateArrays& state);
  void LoadContacts(const StateArrays& state, ContactBuffer& contacts);
  Side SideAt(EntityRow row, const Vector3& point, const StateArrays& state) const;
  void StoreImpulses(ContactBuffer& contacts) const;
  void StoreBodies(std::span<const EntityRow> rows, StateArrays& state);
  RayHit CastRay(const PairRule& rule, const Ray& ray, uint64_t collides_with_bits) const;

  std::vector<Body> bodies_;         // by entity row
  std::vector<PlacedShape> shapes_;  // by geometry row
  uint64_t last_serial_ = 0;
  BroadPhase broad_phase_;
  ContactSolver solver_;

  // Kept between calls for their memory only.
  struct Solved {
    uint32_t point = 0;  // in the contact buffer
    double sign = 1;     // -1 where the solver pushed a instead of b
  };
  std::vector<Candidate> candidates_;
  std::vector<Solved> solved_;
};

}  // namespace genphys::ode_backend

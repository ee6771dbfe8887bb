#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "contact_solver.h"
#include "genphys/backend.h"
#include "genphys/islands.h"
#include "genphys/push_spread.h"
#include "genphys/resting_pairs.h"
#include "shapes.h"
#include "warm_start.h"

namespace genphys::ode_backend {

/// A world on ODE. The library's collision pairs and solver are used, and none of its spaces: what it gives depends on
/// the columns and the active set alone, not on how these came about.
class World final : public BackendWorld {
 public:
  explicit World(const StepperSettings& settings) : solver_(std::in_place, settings) {}

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override;
  void SetActive(std::span<const EntityRow> rows, bool active) override;
  void WriteState(std::span<const EntityRow> rows, const StateArrays& state) override;
  void SetStepper(const StepperSettings& settings) override { solver_->SetStepper(settings); }
  void FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) override;
  void ScaleInertia(std::span<const InertiaScale> scales) override { scales_.assign(scales.begin(), scales.end()); }
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows) override;
  void SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) override;
  void Recall(const ContactBuffer& solved) override;
  void SaveState(std::string& bytes) const override;

 private:
  static constexpr uint32_t kUnsolved = ContactConstraint::kImmovable;

  struct Body {
    EntityId id;          // null: none in this row
    uint64_t serial = 0;  // of the call that added it
    MotionType motion_type = MotionType::kStatic;
    bool is_active = false;
    bool is_moved = false;  // its geometries are not yet where its pose says
    Pose pose;
    bool is_centered = true;         // the centre of mass is the origin of the entity's frame
    uint32_t solved_as = kUnsolved;  // place in the solver, during a solve
    MassProperties mass;
    std::vector<GeometryRow> geometries;
  };

  // A contact's side as the solver needs it.
  struct Side {
    uint32_t solved_as = kUnsolved;
    Vector3 center = Vector3::Zero();            // of mass, world
    Vector3 linear_velocity = Vector3::Zero();   // m/s
    Vector3 angular_velocity = Vector3::Zero();  // rad/s

    Vector3 VelocityAt(const Vector3& point) const { return linear_velocity + angular_velocity.cross(point - center); }
    double RateOf(const JointRow& row, const Vector3& axis) const {
      return axis.dot(row.kind == JointRow::Kind::kLinear ? VelocityAt(row.point) : angular_velocity);
    }
  };

  // All at once; by sweeps from what held it at the last solve, a few that are enough for what rests, or more; by
  // sweeps from nothing.
  enum class Way { kDirect, kBrief, kWarm, kCold };

  // What pushes meet in an island, and how it is solved for that.
  struct Pushes {
    PushSpread spread;
    Way way = Way::kCold;
    bool is_uneven = false;    // pushes meet very different weights
    double softness = 1;       // see ContactConstraint
    bool is_all_given = true;  // to each of its points
    double speed_before = 0;   // m/s, of its contacts at most
  };

  static void Move(Body& body, const Pose& pose);
  static bool StartsFromGiven(Way way) { return way == Way::kBrief || way == Way::kWarm; }
  void PlaceMoved(GeometryRow row);
  Motion MotionOf(EntityRow row, const StateArrays& state) const;
  void ChooseSolvers(const StateArrays& state, const ContactBuffer& contacts, std::span<const JointRow> joint_rows);
  bool IsDirectWanted(const Islands::Island& island) const;
  void SolveGroup(double step_size, Way way, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows);
  const Body* BodyOf(GeometryRow geometry, uint64_t serial) const;
  void BringBack();
  void Recognise(const ContactBuffer& contacts);
  bool RecognisePair(const ContactPair& pair, const ContactBuffer& contacts);
  bool StepDirectly();
  void GiveUpDirect();
  void GiveUpUnheld(Way way, const ContactBuffer& contacts);
  void LoadBodies(const StateArrays& state);
  void LoadRows(const StateArrays& state, std::span<JointRow> joint_rows);
  void LoadContacts(Way way, const StateArrays& state, const ContactBuffer& contacts);
  size_t CountContacts(const ContactBuffer& contacts) const;
  size_t CountGiven() const;
  void LoadContact(const ContactPair& pair, const ContactPoint& point, uint32_t index, const Side& a, const Side& b,
                   double held_depth);
  Side SideOf(EntityRow row, const StateArrays& state) const;
  void NotePush(const Vector3& point, EntityRow row, const StateArrays& state);
  void StoreImpulses(ContactBuffer& contacts) const;
  void StoreBodies(Way way, StateArrays& state);
  void Fly(EntityRow row, double step_size, StateArrays& state);
  void StorePose(EntityRow row, const Vector3& center_of_mass, const Quaternion& orientation, StateArrays& state);

  std::vector<Body> bodies_;         // by entity row
  std::vector<PlacedShape> shapes_;  // by geometry row
  uint64_t last_serial_ = 0;
  std::optional<ContactSolver> solver_;  // there is always one
  WarmStart warm_start_;
  RestingPairs<WarmStart::Kept, uint64_t> resting_;  // by serials
  std::vector<uint64_t> woken_;                      // since the last solve
  bool has_slept_ = false;                           // somebody fell asleep since
  // The exact solver gave up in the middle of a solve. It is not asked again, for each time it leaves memory behind.
  bool has_failed_directly_ = false;

  struct Solved {
    uint32_t point = 0;  // in the contact buffer
    uint32_t island = 0;
    double sign = 1;  // -1 where the solver pushed a instead of b
  };
  // Kept between calls for their memory only.
  std::vector<EntityRow> held_rows_;
  std::vector<EntityRow> solved_rows_;  // of the group that is being solved
  Islands islands_;
  std::vector<Pushes> pushes_;        // by island
  std::vector<InertiaScale> scales_;  // for the next solve
  std::vector<Solved> solved_;
  std::vector<WarmStart::Recalled> recalled_;  // by contact point
};

}  // namespace genphys::ode_backend

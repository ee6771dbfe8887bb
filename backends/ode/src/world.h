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
  explicit World(const StepperSettings& settings) : settings_(settings) {}

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override;
  void SetActive(std::span<const EntityRow> rows, bool active) override;
  void WriteState(std::span<const EntityRow> rows, const StateArrays& state) override;
  void SetStepper(const StepperSettings& settings) override;
  void FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) override;
  void ScaleInertia(std::span<const InertiaScale> scales) override;
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
    double inertia_factor = 1;  // by which it is harder to turn in the next solve
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

  // What the last solve tells of an island.
  struct Known {
    bool is_whole = true;      // every pair was there
    bool is_all_given = true;  // to each of its points
  };

  // How an island is solved, until that does.
  struct Attempt {
    uint32_t island = 0;
    Way way = Way::kCold;
    double softness = 1;  // see ContactConstraint
  };

  static void Move(Body& body, const Pose& pose);
  static bool StartsFromGiven(Way way) { return way == Way::kBrief || way == Way::kWarm; }
  void PlaceMoved(GeometryRow row);
  Motion MotionOf(EntityRow row, const StateArrays& state) const;
  void SolveIslands(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                    std::span<JointRow> joint_rows);
  void TrimSolvers();
  std::optional<ContactSolver>& SolverOf(uint32_t island);
  Attempt FirstAttempt(uint32_t island, const StateArrays& state, const ContactBuffer& contacts,
                       std::span<const JointRow> joint_rows) const;
  bool IsDirectWanted(const Islands::Island& island) const;
  bool MayBeWarm(uint32_t island) const;
  std::optional<Way> SolveIsland(const Attempt& attempt, double step_size, StateArrays& state, ContactBuffer& contacts,
                                 std::span<JointRow> joint_rows);
  const Body* BodyOf(GeometryRow geometry, uint64_t serial) const;
  void BringBack();
  void Recognise(const ContactBuffer& contacts);
  bool RecognisePair(const ContactPair& pair, const ContactBuffer& contacts);
  bool StepDirectly(uint32_t island);
  std::optional<Way> WayAfter(const Attempt& attempt, const ContactBuffer& contacts);
  void LoadBodies(uint32_t island, const StateArrays& state);
  void LoadRows(uint32_t island, const StateArrays& state, std::span<JointRow> joint_rows);
  void LoadContacts(const Attempt& attempt, const StateArrays& state, const ContactBuffer& contacts);
  void LoadContact(const Attempt& attempt, const ContactPair& pair, uint32_t point, const Side& a, const Side& b,
                   const ContactBuffer& contacts, double held_depth);
  Side SideOf(EntityRow row, const StateArrays& state) const;
  void StoreImpulses(uint32_t island, ContactBuffer& contacts);
  void StoreBodies(uint32_t island, StateArrays& state);
  void Fly(EntityRow row, double step_size, StateArrays& state);
  void StorePose(EntityRow row, const Vector3& center_of_mass, const Quaternion& orientation, StateArrays& state);

  std::vector<Body> bodies_;         // by entity row
  std::vector<PlacedShape> shapes_;  // by geometry row
  uint64_t last_serial_ = 0;
  StepperSettings settings_;
  // Of islands of few bodies and of many, each made when it is first needed: a call of ODE costs by all the bodies that
  // its world ever had at a time.
  std::optional<ContactSolver> small_solver_;
  std::optional<ContactSolver> large_solver_;
  WarmStart warm_start_;
  RestingPairs<WarmStart::Kept, uint64_t> resting_;  // by serials
  std::vector<uint64_t> woken_;                      // since the last solve
  bool has_slept_ = false;                           // somebody fell asleep since
  // The exact solver gave up in the middle of a solve. It is not asked again, for each time it leaves memory behind.
  bool has_failed_directly_ = false;

  struct Solved {
    uint32_t point = 0;  // in the contact buffer
    double sign = 1;     // -1 where the solver pushed a instead of b
  };
  // Kept between calls for their memory only.
  Islands islands_;
  std::vector<Known> known_;                   // by island
  std::vector<EntityRow> scaled_;              // who is harder to turn
  std::vector<Solved> solved_;                 // of the island that is being solved
  std::vector<WarmStart::Recalled> recalled_;  // by contact point
};

}  // namespace genphys::ode_backend

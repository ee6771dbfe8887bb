#pragma once
#include <limits>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "genphys/contact.h"
#include "genphys/narrow_phase.h"
#include "genphys/row_marks.h"
#include "impacts/bearings.h"
#include "impacts/crowds.h"
#include "impacts/impact_motion.h"
#include "impacts/impact_past.h"
#include "impacts/impact_speed.h"
#include "impacts/impact_world.h"
#include "impacts/pair_places.h"
#include "impacts/swept_pair.h"
#include "impacts/ties.h"
#include "joints/joint_step.h"
#include "motion/spring_forces.h"

namespace genphys {

/// rad: what turns by less in a substep does not roll far into what it is in touch with.
inline constexpr double kRollingTurn = 0.3;

/// m/s: what slips faster slides, whatever else is known of it.
inline constexpr double kSlidingSpeed = 1e-2;

/// The impacts of one substep: restitution, landing and what flew through something, in one pass after the bodies were
/// moved. Each is taken back to the time at which it happened by the free motion of its bodies, solved there by the
/// laws of Newton and Coulomb, and run forward again. What stands on the ground goes back along its way, too, and the
/// ground takes part in the blow. What lies among others that move goes back when it meets something new that is held
/// as well, as if it were held all the time; of that on which something lands the velocities alone change, and of those
/// that bear it, down to the ground, to which it passes the blow on. Joints pass a blow on to
/// all that they hold, and what bears any of these takes part, down to the ground as well; all that they hold go back
/// together and forward again as joints let them.
class Impacts {
 public:
  /// Without `rewinds` all impacts are those of the present moment.
  Impacts(const ImpactWorld& world, double step_size, bool rewinds);
  Impacts(const Impacts&) = delete;
  Impacts& operator=(const Impacts&) = delete;

  /// Solves the earliest impacts among `contacts` (at the present poses) and `swept`. False: there are none left. Pairs
  /// with none of the rows in `changed` are as they were at the last Solve(), unless it is null. `flown` are the ways
  /// since each body was hit, by row; none without rewinds.
  bool Solve(const ContactBuffer& contacts, const RowMarks* changed, std::span<const SweptPair> swept,
             std::span<const FlownWay> flown);

  /// The ways since they were hit of those that the last Solve() put elsewhere, ascending.
  const std::vector<FlownWay>& moved() const { return moved_; }

  /// Marks whose velocity or place the last Solve() may have changed.
  void MarkStruck(RowMarks& marks) const;

  /// Who went through another, in pairs of which one was hit by somebody else before: their ways must be looked along
  /// again.
  std::vector<EntityRow> WaitingSwept() const;

  /// Whether the two do not collide at a point that closes: a moment later they overlap no more than now, for what is
  /// level lets what slides onto it pass.
  bool OnlySlidesOnto(const ContactPair& pair, const ContactPoint& point) const;
  /// Whether one of the two slides or rolls into the other: an engine would stop it a substep too late or too early,
  /// and in its own way. What only touches something that throws it back is not held by that either.
  bool IsNewAmongHeld(const ContactPair& pair) const;
  /// Whether what touches something that nothing moves, and is not pressed against it, comes down on it so fast (m/s)
  /// that it would be deep in it before a solve stops it.
  bool SlamsOnto(const ContactPair& pair, double closing) const;
  /// Whether two that press against each other, one of which nothing moves, collide at a point far from there: with the
  /// end of what tips about the other one. What rolls meets at points as near to the last one as it goes in a substep.
  bool TipsOnto(const ContactPair& pair, const ContactPoint& point) const;

  /// What all impacts so far passed on, in canonical order within each Solve().
  const ContactBuffer& impulses() const { return impulses_; }

 private:
  struct Candidate {
    ContactPair pair;
    double time = 0;     // s before the end
    double closing = 0;  // m/s
    bool is_swept = false;
    bool is_deep = false;     // it is no more touching by then
    bool were_apart = false;  // it is known that they were, since the last impact of either
    bool is_held = false;     // both are, or cannot be moved
    bool is_beside = false;   // one tips onto the other about where it is pressed against that
    bool is_timed = false;    // it is known when
    double by_depth = 0;      // s before the end, as its points there tell if they are deep, when it is swept
    double gap = 0;           // m, between them when they are hit
    double nearest = 0;       // m, between one of them and whoever hits it then
    bool is_apart = false;    // more than that
    bool is_level = false;    // with what it comes to, and so no impact
    Borne borne = Borne::kUnknown;
    bool is_passed_down = false;  // from what joints hold together to somebody apart from it
  };
  // From one that is hit, or what joints hold together with it, to all that bear it.
  struct Descent {
    Candidate* candidate = nullptr;
    EntityRow hit{};
    int group = -1;  // in groups_
    bool is_whole = true;
    bool is_grounded = false;         // something below is held by what nothing can move
    std::vector<EntityRow> passed{};  // that are in no earlier one, each after those that bear it
    std::vector<size_t> groups{};     // of these
    std::vector<int> shares_with{};   // earlier ones
  };
  struct Struck {
    EntityRow row{};
    ImpactMotion motion;
    double time = 0;      // s before the end at which it is hit
    bool is_hit = false;  // it, or what joints hold it to
    // What its velocity lacks to be as joints let it: the next solve gives it that, and no impact.
    Vector3 lacking_linear = Vector3::Zero();
    Vector3 lacking_angular = Vector3::Zero();
    Vector3 by_others = Vector3::Zero();  // m/s, of how it goes on from the blow to the end: see FlownWay
    double gap = std::numeric_limits<double>::infinity();  // m, to the nearest of those that hit it
  };
  // What joints hold together, and something hits.
  struct Group {
    JointStep::Linked linked;
    bool is_tied = false;             // joints pass on what hits it
    double time = 0;                  // s before the end, of all of it; zero: it does not go back
    std::vector<uint32_t> members{};  // in struck_, as its rows
    // Its bodies: the world, the members, and what they hang on that nothing moves; and between which of these its
    // joints are.
    std::vector<EntityRow> sides{};
    std::vector<std::pair<size_t, size_t>> joined{};
    std::vector<Wrench> wrenches{};  // of what pushes these besides what is known anyway
    bool goes_back() const { return is_tied && time > 0; }
  };
  // Where it is held from the blow on.
  struct Held {
    const Blow* support = nullptr;
    const Candidate* candidate = nullptr;
  };
  // Of two that hardly closed when they met.
  struct Graze {
    double time = 0;  // s before the end, of the last one
    int count = 0;
  };
  // Where and how one that went back is at the end.
  struct Arrival {
    Pose pose;
    Vector3 linear_velocity = Vector3::Zero();
    Vector3 angular_velocity = Vector3::Zero();
    Vector3 acceleration = Vector3::Zero();  // of it since the blow, m/s^2
    Vector3 torque = Vector3::Zero();        // the same, N*m
    Vector3 by_others = Vector3::Zero();     // see FlownWay
  };

  // Of the substep: impacts of one body that are nearer to each other happen at once.
  static constexpr double kSameTime = 0.05;
  // Of impacts in time: how far from touching (m, and of the way of a substep) the other corners of what lands flat may
  // be. Of what is small see FlatGap().
  static constexpr double kFlatGap = 2e-5;
  static constexpr double kFlatPart = 0.03;

  void Find(const ContactBuffer& contacts, const RowMarks* changed, std::span<const SweptPair> swept);
  void FindCrowds(const ContactBuffer& contacts);
  void CountCrowds();
  bool IsCrowded(const ContactPair& pair);
  EntityRow MovableOf(const ContactPair& pair) const;
  void FindMissed(const ContactBuffer& contacts);
  Candidate* CandidateOf(GeometryRow a, GeometryRow b) { return places_.Find(candidates_, a, b); }
  std::optional<Candidate> Judge(const ContactBuffer& contacts, const ContactPair& pair) const;
  bool IsHeldThrough(const ContactPair& pair) const;
  bool IsBesideHeld(const ContactPair& pair, const Vector3& position, const Vector3& velocity) const;
  double TippingSpeed(const ContactPair& pair, const ContactPoint& point) const;
  bool WereApart(const ContactPair& pair, double time, double speed) const;
  bool ComesDeep(const ContactPair& pair, double closing) const;
  bool Overlaps(const ContactBuffer& contacts, const ContactPair& pair) const;
  bool GoesBack(EntityRow row, const Candidate& candidate) const;
  bool AnyGoesBack(const Candidate& candidate) const;
  void FindGoing();
  void Time();
  void KeepEarliest();
  double& EarliestOf(EntityRow row);
  void FindEarliest();
  bool AreEarlierWaiting();
  void Refine(Candidate& candidate) const;
  bool OnlyPassesOver(const Candidate& candidate) const;
  bool HasRolled(const Candidate& candidate, double time) const;
  void NoteGrazes();
  void PutOff(Candidate& candidate) const;
  void CollectStruck(const ContactBuffer& contacts);
  void AddBlows(const ContactBuffer& contacts, Candidate& candidate);
  Vector3 Ask(Blow& blow, const ContactPair& pair) const;
  // m/s, how their surfaces run against each other.
  Vector3 RunAcross(const ContactPair& pair, const Vector3& normal) const;
  double ReachOf(const ContactPair& pair) const;
  double FlatGap(const ContactPair& pair) const;
  void AddBlow(const Candidate& candidate, const Vector3& position, const Vector3& normal);
  bool MarkHit();
  void Separate();
  void Record();
  void Apply(const std::vector<StruckBody>& ends);
  void HoldLocked(EntityRow row, StruckBody& body) const;
  // Of the row in struck_, to which it is added unless it is there.
  uint32_t NumberOf(EntityRow row);
  void AddStruck(EntityRow row, const Candidate& candidate);
  // What holds them after the blow (impact_rest.cc).
  std::vector<StruckBody> RestOfStep();
  void PushAside(const Blow& support, uint32_t bearer, std::vector<StruckBody>& ends) const;
  void RollOn(std::span<const Blow> supports, std::span<const Candidate* const> pairs,
              std::span<const StruckBody> coasting, std::vector<StruckBody>& ends) const;
  bool MayRollOn(uint32_t body, std::span<const Held> touches, const StruckBody& coasting) const;
  std::optional<StruckBody> RolledOn(uint32_t body, std::span<const Held> touches, const StruckBody& coasting) const;
  bool FindTouches(uint32_t body, std::span<const Held> touches, const ImpactMotion& then,
                   std::vector<StruckBody>& bodies, std::vector<Blow>& blows) const;
  bool IsReached(uint32_t body, std::span<const Held> touches, double bend, const StruckBody& ground,
                 const Vector3& place) const;
  double BendOf(uint32_t body, const ContactPair& pair, const StruckBody& then) const;
  // Who takes part in a blow of others (impact_reached.cc).
  void DropUnreached();
  std::vector<Blow> BlowsBesideApart();
  void KeepBlows(absl::FunctionRef<bool(size_t)> stays);
  void VisitTogether(absl::FunctionRef<void(std::span<const uint32_t>)> visit) const;
  bool FindApart();
  bool Reaches(const Candidate& candidate, std::span<const StruckBody> after) const;
  // m, between two that meet in these points; of none, beyond all.
  static double GapOf(std::span<const MeetingPoint> points);
  // What stands on the ground (impact_supports.cc).
  bool IsBorne(EntityRow row) const;
  bool Bears(const ContactBuffer& contacts, const ContactPair& pair, bool is_a) const;
  bool IsMovedApart(EntityRow bearer, EntityRow row) const;
  void AddSupports(const ContactBuffer& contacts);
  void AddGround(const ContactBuffer& contacts);
  bool IsSqueezed(const Group& group) const;
  void ChooseSupports(const Group& group);
  void AddSupportBlows();
  // What bears them that lie among others (impact_passing.cc).
  bool IsPassedOn(const ContactBuffer& contacts, const Candidate& candidate, EntityRow row) const;
  bool FollowDown(EntityRow row, int number, Descent& descent);
  void AddBearers(const ContactBuffer& contacts);
  void AddBearers(const Descent& descent);
  void DropBearers(int group);
  // What joints hold together (impact_ties.cc).
  bool IsLinked(EntityRow row) const;
  const Group* GroupOf(EntityRow row) const;
  bool IsTied(EntityRow row) const;
  void FindGroups();
  size_t AddGroup(EntityRow row);
  void LeaveHeldToSolves();
  void TieStruck();
  void TieAll(Group& group);
  bool Tie(Group& group);
  static JointBody ToJointBody(size_t place, const Pose& pose, const StruckBody& struck);
  std::vector<JointBody> BodiesOf(const Group& group, double time) const;
  std::vector<JointRow> RowsOf(const Group& group, std::span<const JointBody> bodies,
                               std::vector<uint32_t>& slots) const;
  void BearBlows();
  // How it goes on after a blow (impact_arrival.cc).
  void PushOn(std::vector<StruckBody>& ends);
  void PushOn(const Group& group, std::vector<StruckBody>& ends);
  bool IsJolted(EntityRow row) const;
  void AddImpulse(EntityRow row, const Vector3& linear, const Vector3& angular);
  void AddLoose(const Group& group);
  void Dampen(JointRow& row) const;
  bool IsSupport(const ContactPair& pair) const;
  void AddContacts();
  std::vector<Arrival> Arrive(std::span<const StruckBody> ends) const;
  Vector3 TorqueOf(const Arrival& arrival, EntityRow row, const StruckBody& then, double time) const;
  void ArriveTogether(const Group& group, std::vector<Arrival>& arrivals) const;
  void Conform(const Group& group, std::vector<Arrival>& arrivals) const;
  // Where a geometry is `time` seconds later if its entity turns on as it does now, and goes on at `velocity` where the
  // point is.
  Placement InTime(EntityRow entity, GeometryRow geometry, const ContactPoint& point, const Vector3& velocity,
                   double time) const;

  const ImpactWorld& world_;
  double step_size_;
  bool rewinds_;
  ImpactSpeed speed_;
  ImpactPast past_;
  Bearings bearings_;
  std::vector<Candidate> candidates_;
  PairPlaces places_;                           // of candidates_
  std::vector<Candidate> waiting_;              // for earlier ones of their bodies
  std::vector<ContactPair> parting_;            // overlap, and part at the end
  Crowds crowds_;                               // of candidates_
  std::vector<Group> groups_;                   // of the candidates
  std::vector<Candidate> supports_;             // on what those stand that are struck
  std::unordered_map<uint64_t, Graze> grazes_;  // by KeyOf()
  std::vector<EntityRow> going_;                // ascending; see FindGoing()
  int solves_ = 0;
  std::vector<Struck> struck_;
  Ties ties_;                       // of struck_
  std::vector<StruckBody> bodies_;  // of struck_, at their times, moving as joints let them
  std::vector<Blow> blows_;
  std::vector<const Candidate*> blow_pairs_;  // of each blow
  std::vector<Vector3> approaches_;           // m/s, relative velocity at each blow before it
  std::vector<FlownWay> moved_;
  ContactBuffer impulses_;
};

}  // namespace genphys

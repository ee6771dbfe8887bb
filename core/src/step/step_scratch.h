#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "genphys/contact.h"
#include "genphys/math.h"
#include "genphys/row_marks.h"
#include "impacts/impacts.h"
#include "motion/field_forces.h"
#include "motion/mover.h"

namespace genphys {

/// A contact of which friction turns within a substep.
struct FrictionTurn {
  uint32_t point = 0;  // of ContactBuffer::points
  EntityRow a{}, b{};
  Vector3 at = Vector3::Zero();     // where that is given, m
  Vector3 given = Vector3::Zero();  // N*s on b, by friction until then
  double rest = 1;                  // the part of the time that is left for the solve
  // N*s on b, in a substep as it is at the end of this one; as at the end of the solve if unknown.
  std::optional<Vector3> since;
  Vector3 slip_change = Vector3::Zero();  // m/s, until it has turned
  double friction = 0;                    // the coefficient from then on
  bool is_on_face = false;                // points beside each other keep it from rolling
};

/// What rolls by itself on something that nothing moves, and of which resistance to that turns within a substep.
struct RollTurn {
  uint32_t pair = 0;  // of ContactBuffer::pairs
  EntityRow row{};
  double sign = 1;                  // -1 if that is side a
  Vector3 given = Vector3::Zero();  // N*m*s, by what resists until then
  double rest = 1;                  // the part of the time that is left for the solve
  // N*s and N*m*s about its centre of mass, of a substep as it is at the end of this one: with what friction answers,
  // by how much more than on the mean.
  Wrench more;
  double friction = 0;  // m, the coefficient from then on
};

/// By how much something that turned is elsewhere than the velocity of the middle of the substep leads it.
struct TurnShift {
  EntityRow row{};
  Vector3 way = Vector3::Zero();   // m
  Vector3 turn = Vector3::Zero();  // rad
};

/// What a step keeps by row while it runs. It stays with the world for its memory alone, and for what can be checked to
/// be still right: a step that touches few of many entities must not pay for all of them.
struct StepScratch {
  std::vector<Mover> movers;
  ContactBuffer solved_before;  // by the last solve of the step before
  std::vector<FrictionTurn> turns;
  std::vector<RollTurn> rolls;
  std::vector<TurnShift> shifts;

  RowValues<Wrench> wrenches{Wrench{}};               // of commands
  RowValues<Wrench> field_wrenches{Wrench{}};         // of force fields
  RowValues<Wrench> samples{Wrench{}};                // of sampled forces of this step
  RowValues<Wrench> last_samples{Wrench{}};           // of the last one
  RowValues<Vector3> accelerations{Vector3::Zero()};  // from outside, m/s^2
  RowValues<Wrench> uneven{Wrench{}};                 // N*s and N*m*s: see StepRun::NoteUneven()
  std::vector<Vector3> bends;                         // by pair, m/s: how more its surfaces slip
  RowValues<double> drives{0};                        // m/s: see StepRun::FindDrives()
  RowValues<int> struck_index{-1};                    // of impacts
  RowValues<int> group_of{-1};                        // of what joints hold together and impacts hit
  RowValues<int> passed_index{-1};                    // of impacts that are passed on
  RowValues<int> swept_index{-1};                     // of sweeps
  RowValues<int> crowd_number{-1};                    // of who hangs together with whom collides
  RowValues<uint32_t> partners{0};                    // how many touch it
  RowValues<int> places{-1};                          // among those that may fall asleep
  RowValues<double> earliest{0};                      // of impacts, s before the end
  RowValues<uint8_t> stances{0};                      // of who is pressed against something
  RowValues<double> free_since{kAlwaysFree};          // its last impact in this substep, s before the end
  RowMarks shoved;                                    // an impact of this substep hit it where it is at the end
  RowMarks flew;                                      // in flight before the solve
  RowMarks jolted;                                    // the last solve gave it a blow
  RowMarks reached;                                   // it, or what joints hold it to, a limit
  RowMarks is_sampled;                                // has one of `samples`
  RowMarks was_sampled;                               // has one of `last_samples`
  RowMarks jointed;                                   // a joint holds it
  RowMarks linked;                                    // with one that was hit, by joints
  RowMarks held;                                      // something touches or holds it
  RowMarks paid;                                      // all that contacts owed it
  RowMarks changed;                                   // place or velocity, in the last impacts
  RowMarks moved;                                     // since the last search for contacts
  RowMarks tested;                                    // active in some search for contacts of this step
  RowMarks flies;                                     // in the flight lane
  RowMarks steered;                                   // forces turn it or turn with it
  RowMarks strays;                                    // left the bounds of the world
  RowMarks pushed;                                    // out of an overlap, or through free space: does not rest

  void Begin(uint32_t rows) {
    const auto reset = [&](auto&... all) { (..., (all.Clear(), all.Resize(rows))); };
    reset(drives, uneven, wrenches, field_wrenches, samples, last_samples, is_sampled, was_sampled, accelerations,
          struck_index, group_of, swept_index, partners, places, earliest, free_since, stances, passed_index,
          crowd_number, flew, jolted, reached, jointed, linked, held, paid, changed, moved, tested, flies, steered,
          strays, pushed, shoved);
  }
};

}  // namespace genphys

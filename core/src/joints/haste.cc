#include "joints/haste.h"

#include <algorithm>
#include <cmath>

#include "genphys/contact.h"
#include "genphys/most_press.h"
#include "joints/row_writer.h"

namespace genphys {
namespace {

// What fell short by more than this part of what was wanted got nowhere.
constexpr double kNowhere = 0.5;
// Of the speed at which all creep: what falls short by less is in nobody's way.
constexpr double kNear = 0.02;
// What lets a joint close again hardly ever does so at once: haste that comes back faster asks for far more, and what
// follows from that.
constexpr double kRecovery = 1.2;
// With which the fastest corrections creep.
constexpr double kLeastHaste = 1.0 / 256;

double Square(double x) { return x * x; }

// By how much a row that moves at `rate` fell short of its target.
double MissedBy(const JointRow& row, double rate) {
  const double missed = row.target - rate - row.softness * row.impulse;
  if (row.lower == 0) return std::max(missed, 0.0);
  return row.upper == 0 ? std::min(missed, 0.0) : missed;
}

}  // namespace

double HasteWatch::Recovered(double haste) { return std::min(kRecovery * haste, 1.0); }

// At `creeping` all may go on as before.
bool HasteWatch::Shortage::IsAny(double creeping) const {
  return missed > std::max(Square(kNowhere) * wanted, Square(kNear * creeping));
}

const JointBody& HasteWatch::BodyAt(EntityRow side) const {
  return bodies_[side == kWorldRow ? 0 : body_of_[Index(side)]];
}

Velocities HasteWatch::VelocitiesOf(EntityRow side) const {
  if (side == kWorldRow) return {};
  return {state_.linear_velocities.col(Index(side)), state_.angular_velocities.col(Index(side))};
}

double HasteWatch::After(std::span<const JointRow> own, uint32_t island, double haste) {
  if (islands_.islands()[island].contacts == 0) return Recovered(haste);
  Shortage along, about;
  double pressed = 0;
  for (const JointRow& row : own) {
    if (row.is_driven) continue;
    const double rate = RateOf(row, BodyAt(row.a), VelocitiesOf(row.a), BodyAt(row.b), VelocitiesOf(row.b));
    const double missed = MissedBy(row, rate);
    Shortage& shortage = row.kind == JointRow::Kind::kLinear ? along : about;
    if (IsLocked(row) || missed != 0) shortage.wanted += Square(row.target);
    shortage.missed += Square(missed);
    pressed += std::abs(row.impulse);
  }
  if (!along.IsAny(kCreepingSpeed) && !about.IsAny(kCreepingSpin)) return Recovered(haste);
  const bool is_asked = along.wanted > Square(kCreepingSpeed) || about.wanted > Square(kCreepingSpin);
  return is_asked && pressed > UsualPress(island) ? std::max(haste / 2, kLeastHaste) : haste;
}

double HasteWatch::UsualPress(uint32_t island) {
  if (presses_.empty()) presses_.assign(islands_.islands().size(), -1);
  if (presses_[island] >= 0) return presses_[island];
  const double pull = scene_.world.gravity.norm();
  MostPress press(h_ * (pull > 0 ? pull : ContactBuffer::kUsualPull));
  // Not with how it moves: what a jam has thrown would be fast enough for any press.
  for (const EntityRow row : islands_.RowsOf(island)) {
    press.AddWeight(scene_.entities[Index(row)]->mass.mass);
  }
  for (const uint32_t i : islands_.JointRowsOf(island)) press.AddDrive(rows_[i]);
  return presses_[island] = press.usual();
}

}  // namespace genphys

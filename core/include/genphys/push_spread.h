#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "genphys/contact.h"
#include "genphys/islands.h"
#include "genphys/joint_row.h"
#include "genphys/math.h"

namespace genphys {

/// How differently what lies in an island answers to pushes. Where something heavy lies on something light, sweeps come
/// no nearer to what bears it.
class PushSpread {
 public:
  /// From this on it is uneven, and solved all at once while that is little work.
  static constexpr double kUneven = 50;

  /// What pushes find of a body.
  struct Mass {
    Vector3 center = Vector3::Zero();  // of mass, m, world
    double inverse_mass = 0;           // 1/kg
    double inverse_inertia = 0;        // 1/(kg*m^2), the norm of the inverse tensor
  };

  /// Value() of an island, of all that its contacts and joints push. mass_of(row) tells the Mass of a row that can be
  /// moved.
  template <typename MassOf>
  static double Of(const Islands& islands, uint32_t island, const ContactBuffer& contacts,
                   std::span<const JointRow> joint_rows, const MassOf& mass_of) {
    PushSpread spread;
    for (const uint32_t number : islands.PairsOf(island)) {
      const ContactPair& pair = contacts.pairs[number];
      for (const EntityRow row : {pair.entity_a, pair.entity_b}) {
        if (islands.IslandOf(row) == Islands::kNone) continue;
        const Mass mass = mass_of(row);
        for (const ContactPoint& point : std::span(contacts.points).subspan(pair.first_point, pair.point_count)) {
          spread.Note(point.position - mass.center, mass.inverse_mass, mass.inverse_inertia);
        }
      }
    }
    for (const uint32_t number : islands.JointRowsOf(island)) {
      const JointRow& row = joint_rows[number];
      if (row.kind != JointRow::Kind::kLinear) continue;
      for (const EntityRow side : {row.a, row.b}) {
        if (islands.IslandOf(side) == Islands::kNone) continue;
        const Mass mass = mass_of(side);
        spread.Note(row.point - mass.center, mass.inverse_mass, mass.inverse_inertia);
      }
    }
    return spread.Value();
  }

  /// Of a push at `arm` (m) from a centre of mass, in whatever direction. `inverse_inertia` (1/(kg*m^2)) is the norm of
  /// the inverse tensor.
  void Note(const Vector3& arm, double inverse_mass, double inverse_inertia) {
    const double mobility = inverse_mass + arm.squaredNorm() * inverse_inertia;
    easiest_ = std::max(easiest_, mobility);
    hardest_ = std::min(hardest_, mobility);
  }

  /// How many times more one of them moves what it meets than another one; 1 if there was none.
  double Value() const { return easiest_ > 0 ? easiest_ / hardest_ : 1; }

 private:
  double easiest_ = 0;  // 1/kg
  double hardest_ = std::numeric_limits<double>::infinity();
};

}  // namespace genphys

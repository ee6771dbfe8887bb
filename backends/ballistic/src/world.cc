#include "world.h"

#include "genphys/contact_sweeps.h"

namespace genphys::ballistic_backend {

void World::AddBody(const BodyDesc& desc, const StateArrays&) {
  if (Index(desc.row) >= centers_of_mass_.size()) centers_of_mass_.resize(Index(desc.row) + 1);
  centers_of_mass_[Index(desc.row)] = desc.mass.center_of_mass;
}

void World::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer&,
                  std::span<JointRow>) {
  for (EntityRow row : rows) {
    const SweptBody body{.linear_velocity = state.linear_velocities.col(Index(row)),
                         .angular_velocity = state.angular_velocities.col(Index(row))};
    state.set_pose(row, MovedBy(body, step_size, centers_of_mass_[Index(row)], state.pose(row)));
  }
}

}  // namespace genphys::ballistic_backend

#include "world.h"

#include "contacts.h"
#include "library.h"

namespace genphys::ode_backend {

void World::AddBody(const BodyDesc& desc, const StateArrays& state) {
  PrepareThread();
  for (size_t i = 0; i < desc.geometries.size(); ++i) {
    const GeometryRow row = desc.geometries[i];
    if (Index(row) >= shapes_.size()) shapes_.resize(Index(row) + 1);
    shapes_[Index(row)] = OdeShape(desc.body.geometries[i].shape);
  }
  SweptWorld::AddBody(desc, state);
}

void World::RemoveBody(EntityRow row) {
  for (const GeometryRow geometry : body(row).geometries) shapes_[Index(geometry)] = {};
  SweptWorld::RemoveBody(row);
}

void World::FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) {
  PrepareThread();
  ode_backend::FindPoints({Placed(a), shapes_[Index(a)]}, {Placed(b), shapes_[Index(b)]}, points);
}

void World::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) {
  PrepareThread();
  most_exact_ = 0;
  SweptWorld::Solve(step_size, rows, state, contacts, joint_rows);
  // Bodies that were in use in solves before this one need not be any more.
  if (exact_) exact_->Trim(most_exact_);
}

void World::SaveState(std::string& bytes) const {
  SweptWorld::SaveState(bytes);
  bytes.push_back(has_failed_exactly_ ? 1 : 0);
}

}  // namespace genphys::ode_backend

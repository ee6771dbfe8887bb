#include "genphys/held_shapes.h"

#include "genphys/surface.h"

namespace genphys {

const void* HeldShapes::DataOf(const Shape& shape) {
  if (const auto* hull = std::get_if<ConvexHull>(&shape)) return hull->data.get();
  if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) return mesh->data.get();
  if (const auto* field = std::get_if<Heightfield>(&shape)) return field->data.get();
  return nullptr;
}

void HeldShapes::Add(const Shape& shape) {
  const void* const data = DataOf(shape);
  if (data == nullptr) return;
  Held& held = held_[data];
  if (held.uses++ > 0) return;
  held.bytes = DataBytesOf(shape);
  bytes_ += held.bytes;
}

void HeldShapes::Remove(const void* data) {
  const auto found = data == nullptr ? held_.end() : held_.find(data);
  if (found == held_.end() || --found->second.uses > 0) return;
  bytes_ -= found->second.bytes;
  held_.erase(found);
}

}  // namespace genphys

#pragma once
#include <cstddef>
#include <unordered_map>

#include "genphys/shape.h"

namespace genphys {

/// What the data of the hulls, meshes and heightfields of a world takes, that of copies counted once.
class HeldShapes {
 public:
  /// The data that `shape` shares with its copies; null if it has none.
  static const void* DataOf(const Shape& shape);

  void Add(const Shape& shape);
  /// One use less of what was added as DataOf() says. Null: nothing.
  void Remove(const void* data);

  bool Has(const void* data) const { return held_.contains(data); }
  size_t bytes() const { return bytes_; }

 private:
  struct Held {
    size_t uses = 0;
    size_t bytes = 0;
  };

  std::unordered_map<const void*, Held> held_;
  size_t bytes_ = 0;
};

}  // namespace genphys

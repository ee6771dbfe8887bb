#pragma once
#include <absl/container/inlined_vector.h>

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "genphys/contact.h"
#include "genphys/entity.h"
#include "genphys/held_shapes.h"

namespace genphys {

/// The geometries of one entity, in the order of its description. Most have one or two, which lie with it in memory.
using GeometryRows = absl::InlinedVector<GeometryRow, 4>;

/// What a pair of geometries may do to each other, decided by the layer so that every engine decides alike.
class PairRule final {
 public:
  enum class Verdict : uint8_t { kIgnore, kSensor, kCollide };

  /// What the rule must know of one geometry.
  struct GeometryInfo {
    EntityRow entity{};
    uint32_t geometry_id = 0;  // unique in its entity
    EntityId entity_id;        // null: a hole
    uint64_t category_bits = 0;
    uint64_t collides_with_bits = 0;
    uint32_t space = 0;  // root of its collision space; zero: none
    bool is_sensor = false;
    bool is_static = false;                      // of a static entity
    bool is_dynamic = false;                     // of a dynamic entity
    bool rolls = false;                          // some of its surface is curved
    Material material;                           // filled
    Vector3 surface_velocity = Vector3::Zero();  // m/s, in the frame of the entity
    ErrorCorrection correction;                  // filled
    const void* data = nullptr;                  // of its shape: see HeldShapes
  };

  /// Symmetric: nothing that is disregarded collides; each side must be in the other's mask; members of one space and
  /// of one entity ignore each other, and so do two geometries neither of which is dynamic, unless one is a sensor and
  /// they are not both static.
  Verdict Decide(GeometryRow a, GeometryRow b) const;

  /// Whether a ray that collides with `bits` sees this geometry. Sensors are never seen.
  bool SeenByRay(GeometryRow geometry, uint64_t bits) const;

  MixedMaterial Mixed(GeometryRow a, GeometryRow b) const;

  /// How the overlap of both is taken away.
  ErrorCorrection Correction(GeometryRow a, GeometryRow b) const {
    return Gentler(infos_[Index(a)].correction, infos_[Index(b)].correction);
  }

  /// Whether the surface of any geometry runs over it.
  bool any_surface_runs() const { return running_surfaces_ > 0; }
  /// Whether that of this one does.
  bool Runs(GeometryRow row) const { return !infos_[Index(row)].surface_velocity.isZero(0); }

  /// True if `a` belongs before `b` in canonical order: by entity id, then geometry id.
  bool Before(GeometryRow a, GeometryRow b) const;

  const GeometryInfo& info(GeometryRow row) const { return infos_[Index(row)]; }
  size_t geometry_count() const { return infos_.size() - free_.size(); }
  const HeldShapes& shapes() const { return shapes_; }

  /// Registers the geometries of one entity and returns their rows.
  GeometryRows Add(EntityRow entity, EntityId id, const RigidBody& body);
  void Remove(std::span<const GeometryRow> rows);

  /// From now on the two entities ignore each other, until as many calls of Regard(). Either may be gone.
  void Disregard(EntityId a, EntityId b);
  void Regard(EntityId a, EntityId b);

 private:
  uint32_t SpaceRoot(const std::string& collision_space);

  std::vector<GeometryInfo> infos_;
  size_t running_surfaces_ = 0;
  std::vector<GeometryRow> free_;
  HeldShapes shapes_;
  std::unordered_map<std::string, uint32_t> space_roots_;
  struct HashOfTwo {
    size_t operator()(const std::pair<EntityId, EntityId>& two) const {
      // Near ids differ in their lowest bits alone; an odd factor of full length brings those of one to the top.
      return two.first.packed() * 0x9e3779b97f4a7c15 + two.second.packed();
    }
  };
  std::unordered_map<std::pair<EntityId, EntityId>, uint32_t, HashOfTwo> disregarded_;  // how often
};

}  // namespace genphys

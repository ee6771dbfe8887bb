#pragma once
#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <vector>

#include "body.h"

namespace genphys::bullet_backend {

/// Two geometries whose bounds overlap and that may have to do with each other, in canonical order.
struct CandidatePair {
  PlacedGeometry* a = nullptr;
  PlacedGeometry* b = nullptr;
  bool is_sensor = false;
};

/// Canonical order of pairs, as ContactBuffer has it.
bool ComesBefore(const CandidatePair& x, const CandidatePair& y);

/// Finds who is near whom: what moves is in one of Bullet's trees and what rests is in another, which is only asked by
/// the first. Which pairs it finds depends on the bounds alone, not on the history of the trees.
class BroadPhase {
 public:
  void Add(Body& body);
  void Remove(Body& body);
  /// Puts a body into the tree in which its activity says it belongs.
  void Refile(Body& body);
  /// Tells that the bounds of the body's geometries have changed.
  void Update(Body& body);

  /// Overwrites `pairs` with those that `rule` does not ignore, ascending; one side at least is moving.
  void FindPairs(const PairRule& rule, std::vector<CandidatePair>& pairs);

  /// Overwrites `found` with the geometries whose bounds the segment may cross, and with all planes.
  void FindOnSegment(const Vector3& start, const Vector3& end, std::vector<const PlacedGeometry*>& found);

  /// Overwrites `found` with the geometries whose leaves overlap `bounds`, and with all planes.
  void FindInBounds(const Bounds& bounds, std::vector<const PlacedGeometry*>& found);

 private:
  btDbvt moving_;
  btDbvt resting_;
  std::vector<PlacedGeometry*> planes_;  // unbounded, so in no tree
  btAlignedObjectArray<const btDbvtNode*> ray_stack_;
};

}  // namespace genphys::bullet_backend

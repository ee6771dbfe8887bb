#include <utility>

#include "connection.h"
#include "genphys/client/world.h"
#include "genphys/wire/query.h"

namespace genphys::client {
namespace {

using Simulation = v1::SimulationService::Stub;

}  // namespace

Result<std::vector<RayHit>> World::CastRays(std::span<const Ray> rays, uint64_t collides_with_bits) const {
  v1::CastRaysRequest request;
  request.set_world(name_);
  request.set_collides_with_bits(collides_with_bits);
  EncodeRays(rays, &request);
  v1::CastRaysResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::CastRays, request, &response));
  return DecodeRayHits(response);
}

Result<std::vector<std::vector<RayEntry>>> World::CastRaysThrough(std::span<const Ray> rays,
                                                                  uint64_t collides_with_bits) const {
  v1::CastRaysRequest request;
  request.set_world(name_);
  request.set_collides_with_bits(collides_with_bits);
  request.set_all_hits(true);
  EncodeRays(rays, &request);
  v1::CastRaysResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::CastRays, request, &response));
  return DecodeRayEntries(response);
}

Result<std::vector<ShapeCastHit>> World::CastShape(const Shape& shape, std::span<const Pose> poses,
                                                   std::span<const Vector3> translations,
                                                   uint64_t collides_with_bits) const {
  v1::CastShapeRequest request;
  request.set_world(name_);
  request.set_collides_with_bits(collides_with_bits);
  EncodePosedShape(shape, poses, &request);
  EncodeTranslations(translations, &request);
  v1::CastShapeResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::CastShape, request, &response));
  return DecodeShapeCastHits(response);
}

Result<std::vector<std::vector<GeometryId>>> World::FindOverlaps(const Shape& shape, std::span<const Pose> poses,
                                                                 uint64_t collides_with_bits) const {
  v1::FindOverlapsRequest request;
  request.set_world(name_);
  request.set_collides_with_bits(collides_with_bits);
  EncodePosedShape(shape, poses, &request);
  v1::FindOverlapsResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::FindOverlaps, request, &response));
  return DecodeOverlaps(response);
}

Result<std::vector<ClosestPoints>> World::FindClosest(const Shape& shape, std::span<const Pose> poses,
                                                      double distance_max, uint64_t collides_with_bits) const {
  v1::FindClosestRequest request;
  request.set_world(name_);
  request.set_collides_with_bits(collides_with_bits);
  request.set_distance_max(distance_max);
  EncodePosedShape(shape, poses, &request);
  v1::FindClosestResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::FindClosest, request, &response));
  return DecodeClosest(response.closest());
}

Result<std::vector<ClosestPoints>> World::MeasureDistances(std::span<const EntityId> from,
                                                           std::span<const EntityId> to) const {
  v1::MeasureDistancesRequest request;
  request.set_world(name_);
  EncodeIdPairs(from, to, &request);
  v1::MeasureDistancesResponse response;
  GENPHYS_RETURN_IF_ERROR(
      connection_->Call(connection_->simulation(), &Simulation::MeasureDistances, request, &response));
  return DecodeClosest(response.closest());
}

Result<std::vector<EntityContact>> World::ContactsOf(EntityId id) const {
  v1::GetContactsRequest request;
  request.set_world(name_);
  request.set_entity_id(id.packed());
  v1::GetContactsResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->simulation(), &Simulation::GetContacts, request, &response));
  return DecodeContacts(response);
}

}  // namespace genphys::client

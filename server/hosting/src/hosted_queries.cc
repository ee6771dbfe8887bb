#include "genphys/wire/query.h"
#include "hosted_world.h"

namespace genphys {
namespace {

template <typename Request>
uint64_t BitsOf(const Request& request) {
  return request.has_collides_with_bits() ? request.collides_with_bits() : ~uint64_t{0};
}

// m: as the contract says of an unset distance.
constexpr double kDistanceMax = 100;

}  // namespace

Result<v1::CastRaysResponse> HostedWorld::CastRays(const v1::CastRaysRequest& request) {
  GENPHYS_RETURN_IF_ERROR(CheckReadable());
  const Result<std::vector<Ray>> rays = DecodeRays(request);
  if (!rays.ok()) return rays.status();
  v1::CastRaysResponse response;
  stamp().Encode(response.mutable_stamp());
  if (request.all_hits()) {
    const auto entries = world_->CastRaysThrough(*rays, BitsOf(request));
    if (!entries.ok()) return entries.status();
    EncodeRayEntries(*entries, &response);
  } else {
    const Result<std::vector<RayHit>> hits = world_->CastRays(*rays, BitsOf(request));
    if (!hits.ok()) return hits.status();
    EncodeRayHits(*hits, &response);
  }
  return response;
}

Result<v1::CastShapeResponse> HostedWorld::CastShape(const v1::CastShapeRequest& request) {
  GENPHYS_RETURN_IF_ERROR(CheckReadable());
  const Result<PosedShape> query = DecodePosedShape(request);
  if (!query.ok()) return query.status();
  const auto hits = world_->CastShape(query->shape, query->poses, DecodeTranslations(request), BitsOf(request));
  if (!hits.ok()) return hits.status();
  v1::CastShapeResponse response;
  stamp().Encode(response.mutable_stamp());
  EncodeShapeCastHits(*hits, &response);
  return response;
}

Result<v1::FindOverlapsResponse> HostedWorld::FindOverlaps(const v1::FindOverlapsRequest& request) {
  GENPHYS_RETURN_IF_ERROR(CheckReadable());
  const Result<PosedShape> query = DecodePosedShape(request);
  if (!query.ok()) return query.status();
  const auto overlaps = world_->FindOverlaps(query->shape, query->poses, BitsOf(request));
  if (!overlaps.ok()) return overlaps.status();
  v1::FindOverlapsResponse response;
  stamp().Encode(response.mutable_stamp());
  EncodeOverlaps(*overlaps, &response);
  return response;
}

Result<v1::FindClosestResponse> HostedWorld::FindClosest(const v1::FindClosestRequest& request) {
  GENPHYS_RETURN_IF_ERROR(CheckReadable());
  const Result<PosedShape> query = DecodePosedShape(request);
  if (!query.ok()) return query.status();
  const double distance_max = request.has_distance_max() ? request.distance_max() : kDistanceMax;
  const auto closest = world_->FindClosest(query->shape, query->poses, distance_max, BitsOf(request));
  if (!closest.ok()) return closest.status();
  v1::FindClosestResponse response;
  stamp().Encode(response.mutable_stamp());
  EncodeClosest(*closest, response.mutable_closest());
  return response;
}

Result<v1::MeasureDistancesResponse> HostedWorld::MeasureDistances(const v1::MeasureDistancesRequest& request) {
  const auto distances = world_->MeasureDistances(DecodeIds(request.from_ids()), DecodeIds(request.to_ids()));
  if (!distances.ok()) return distances.status();
  v1::MeasureDistancesResponse response;
  stamp().Encode(response.mutable_stamp());
  EncodeClosest(*distances, response.mutable_closest());
  return response;
}

Result<v1::GetContactsResponse> HostedWorld::GetContacts(const v1::GetContactsRequest& request) {
  const auto contacts = world_->ContactsOf(EntityId::FromPacked(request.entity_id()));
  if (!contacts.ok()) return contacts.status();
  v1::GetContactsResponse response;
  stamp().Encode(response.mutable_stamp());
  EncodeContacts(*contacts, &response);
  return response;
}

}  // namespace genphys

#pragma once
#include <span>
#include <vector>

#include "genphys/query.h"
#include "genphys/status.h"
#include "genphys/v1/query.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"

// Queries and their answers in both directions. Requests have passed ValidateLimits(); answers are checked here.

namespace genphys {

/// One shape at many places.
struct PosedShape {
  Shape shape;
  std::vector<Pose> poses;
};

/// The shape and places of a request. Refuses a shape that is none, and columns that differ in their number of rows.
Result<PosedShape> DecodePosedShape(const v1::CastShapeRequest& request);
Result<PosedShape> DecodePosedShape(const v1::FindOverlapsRequest& request);
Result<PosedShape> DecodePosedShape(const v1::FindClosestRequest& request);
std::vector<Vector3> DecodeTranslations(const v1::CastShapeRequest& request);

void EncodePosedShape(const Shape& shape, std::span<const Pose> poses, v1::CastShapeRequest* out);
void EncodePosedShape(const Shape& shape, std::span<const Pose> poses, v1::FindOverlapsRequest* out);
void EncodePosedShape(const Shape& shape, std::span<const Pose> poses, v1::FindClosestRequest* out);
void EncodeTranslations(std::span<const Vector3> translations, v1::CastShapeRequest* out);
void EncodeIdPairs(std::span<const EntityId> from, std::span<const EntityId> to, v1::MeasureDistancesRequest* out);

void EncodeRayEntries(std::span<const std::vector<RayEntry>> entries, v1::CastRaysResponse* out);
void EncodeShapeCastHits(std::span<const ShapeCastHit> hits, v1::CastShapeResponse* out);
void EncodeOverlaps(std::span<const std::vector<GeometryId>> overlaps, v1::FindOverlapsResponse* out);
void EncodeClosest(std::span<const ClosestPoints> closest, v1::ClosestColumns* out);
void EncodeContacts(std::span<const EntityContact> contacts, v1::GetContactsResponse* out);

/// INVALID_VALUE, at the column, when an answer's columns do not go together.
Result<std::vector<std::vector<RayEntry>>> DecodeRayEntries(const v1::CastRaysResponse& response);
Result<std::vector<ShapeCastHit>> DecodeShapeCastHits(const v1::CastShapeResponse& response);
Result<std::vector<std::vector<GeometryId>>> DecodeOverlaps(const v1::FindOverlapsResponse& response);
Result<std::vector<ClosestPoints>> DecodeClosest(const v1::ClosestColumns& columns);
std::vector<EntityContact> DecodeContacts(const v1::GetContactsResponse& response);

}  // namespace genphys

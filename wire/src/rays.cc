#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "values.h"

namespace genphys {
namespace {

Status UnevenColumns(std::string_view field) {
  return Refuse(Reason::kInvalidValue, field, std::string(field) + " has not as many rows as there are rays");
}

}  // namespace

Result<std::vector<Ray>> DecodeRays(const v1::CastRaysRequest& request) {
  const std::vector<Vector3> origins = DecodeColumn<Vector3>(request.origins());
  const std::vector<Vector3> translations = DecodeColumn<Vector3>(request.translations());
  if (translations.size() != origins.size()) return UnevenColumns("translations");
  std::vector<Ray> rays(origins.size());
  for (size_t i = 0; i < rays.size(); ++i) rays[i] = {origins[i], translations[i]};
  return rays;
}

void EncodeRays(std::span<const Ray> rays, v1::CastRaysRequest* out) {
  std::vector<Vector3> origins, translations;
  for (const Ray& ray : rays) {
    origins.push_back(ray.origin);
    translations.push_back(ray.translation);
  }
  EncodeColumn(origins, out->mutable_origins());
  EncodeColumn(translations, out->mutable_translations());
}

Result<std::vector<RayHit>> DecodeRayHits(const v1::CastRaysResponse& response) {
  const std::vector<EntityId> entities = DecodeIds(response.entity_ids());
  const std::vector<double> fractions = DecodeColumn<double>(response.fractions());
  const std::vector<Vector3> normals = DecodeColumn<Vector3>(response.normals());
  if (fractions.size() != entities.size()) return UnevenColumns("fractions");
  if (normals.size() != entities.size()) return UnevenColumns("normals");
  std::vector<RayHit> hits(entities.size());
  for (size_t i = 0; i < hits.size(); ++i) hits[i] = {entities[i], fractions[i], normals[i]};
  return hits;
}

void EncodeRayHits(std::span<const RayHit> hits, v1::CastRaysResponse* out) {
  std::vector<EntityId> entities;
  std::vector<double> fractions;
  std::vector<Vector3> normals;
  for (const RayHit& hit : hits) {
    entities.push_back(hit.entity);
    fractions.push_back(hit.entity.is_null() ? 1 : hit.fraction);
    normals.push_back(hit.entity.is_null() ? Vector3(Vector3::Zero()) : hit.normal);
  }
  EncodeColumn(entities, out->mutable_entity_ids());
  EncodeColumn(fractions, out->mutable_fractions());
  EncodeColumn(normals, out->mutable_normals());
}

}  // namespace genphys

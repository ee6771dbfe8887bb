#include <numeric>
#include <string>
#include <string_view>

#include "genphys/wire/query.h"
#include "shape_message.h"
#include "values.h"

namespace genphys {
namespace {

Status Uneven(std::string_view column) {
  return Refuse(Reason::kInvalidValue, column, std::string(column) + " has not as many rows as the others");
}

template <typename Request>
Result<PosedShape> Decode(const Request& request) {
  Result<Shape> shape = DecodeShape(request.shape());
  if (!shape.ok()) return WithFieldPrefix(shape.status(), "shape");
  PosedShape query{*std::move(shape), {}};
  for (const Vector3& position : DecodeColumn<Vector3>(request.positions())) query.poses.push_back({position});
  const std::vector<Column4> orientations = DecodeColumn<Column4>(request.orientations());
  if (orientations.empty()) return query;
  if (orientations.size() != query.poses.size()) return Uneven("orientations");
  for (size_t i = 0; i < orientations.size(); ++i) query.poses[i].orientation = FromColumn(orientations[i]);
  return query;
}

template <typename Request>
void Encode(const Shape& shape, std::span<const Pose> poses, Request* out) {
  EncodeShape(shape, out->mutable_shape());
  std::vector<Vector3> positions;
  std::vector<Column4> orientations;
  for (const Pose& pose : poses) {
    positions.push_back(pose.position);
    orientations.push_back(ToColumn(pose.orientation));
  }
  EncodeColumn(positions, out->mutable_positions());
  EncodeColumn(orientations, out->mutable_orientations());
}

// Ids and numbers of geometries, column by column.
template <typename Message>
void EncodeHits(const std::vector<GeometryId>& hits, Message* out) {
  std::vector<EntityId> entities;
  out->mutable_geometry_ids()->Reserve(static_cast<int>(hits.size()));
  for (const GeometryId& hit : hits) {
    entities.push_back(hit.entity);
    out->add_geometry_ids(hit.geometry);
  }
  EncodeColumn(entities, out->mutable_entity_ids());
}

template <typename Message>
Result<std::vector<GeometryId>> DecodeHits(const Message& message) {
  const std::vector<EntityId> entities = DecodeIds(message.entity_ids());
  if (entities.size() != static_cast<size_t>(message.geometry_ids_size())) return Uneven("geometry_ids");
  std::vector<GeometryId> hits(entities.size());
  for (size_t i = 0; i < hits.size(); ++i) hits[i] = {entities[i], message.geometry_ids(static_cast<int>(i))};
  return hits;
}

// Cuts rows into lists of the given lengths.
template <typename Row, typename Counts>
Result<std::vector<std::vector<Row>>> Split(const std::vector<Row>& rows, const Counts& counts) {
  const auto total = std::accumulate(counts.begin(), counts.end(), uint64_t{0});
  if (total != rows.size()) return Uneven("hit_counts");
  std::vector<std::vector<Row>> lists;
  auto next = rows.begin();
  for (const uint32_t count : counts) {
    lists.emplace_back(next, next + count);
    next += count;
  }
  return lists;
}

}  // namespace

Result<PosedShape> DecodePosedShape(const v1::CastShapeRequest& request) { return Decode(request); }
Result<PosedShape> DecodePosedShape(const v1::FindOverlapsRequest& request) { return Decode(request); }
Result<PosedShape> DecodePosedShape(const v1::FindClosestRequest& request) { return Decode(request); }

std::vector<Vector3> DecodeTranslations(const v1::CastShapeRequest& request) {
  return DecodeColumn<Vector3>(request.translations());
}

void EncodePosedShape(const Shape& shape, std::span<const Pose> poses, v1::CastShapeRequest* out) {
  Encode(shape, poses, out);
}
void EncodePosedShape(const Shape& shape, std::span<const Pose> poses, v1::FindOverlapsRequest* out) {
  Encode(shape, poses, out);
}
void EncodePosedShape(const Shape& shape, std::span<const Pose> poses, v1::FindClosestRequest* out) {
  Encode(shape, poses, out);
}

void EncodeTranslations(std::span<const Vector3> translations, v1::CastShapeRequest* out) {
  EncodeColumn(std::vector<Vector3>(translations.begin(), translations.end()), out->mutable_translations());
}

void EncodeIdPairs(std::span<const EntityId> from, std::span<const EntityId> to, v1::MeasureDistancesRequest* out) {
  EncodeColumn(std::vector<EntityId>(from.begin(), from.end()), out->mutable_from_ids());
  EncodeColumn(std::vector<EntityId>(to.begin(), to.end()), out->mutable_to_ids());
}

void EncodeRayEntries(std::span<const std::vector<RayEntry>> entries, v1::CastRaysResponse* out) {
  std::vector<GeometryId> hits;
  std::vector<double> fractions;
  std::vector<Vector3> normals;
  for (const std::vector<RayEntry>& of_ray : entries) {
    out->add_hit_counts(static_cast<uint32_t>(of_ray.size()));
    for (const RayEntry& entry : of_ray) {
      hits.push_back(entry.hit);
      fractions.push_back(entry.fraction);
      normals.push_back(entry.normal);
    }
  }
  EncodeHits(hits, out);
  EncodeColumn(fractions, out->mutable_fractions());
  EncodeColumn(normals, out->mutable_normals());
}

Result<std::vector<std::vector<RayEntry>>> DecodeRayEntries(const v1::CastRaysResponse& response) {
  const Result<std::vector<GeometryId>> hits = DecodeHits(response);
  if (!hits.ok()) return hits.status();
  const std::vector<double> fractions = DecodeColumn<double>(response.fractions());
  const std::vector<Vector3> normals = DecodeColumn<Vector3>(response.normals());
  if (fractions.size() != hits->size()) return Uneven("fractions");
  if (normals.size() != hits->size()) return Uneven("normals");
  std::vector<RayEntry> entries(hits->size());
  for (size_t i = 0; i < entries.size(); ++i) entries[i] = {(*hits)[i], fractions[i], normals[i]};
  return Split(entries, response.hit_counts());
}

void EncodeShapeCastHits(std::span<const ShapeCastHit> hits, v1::CastShapeResponse* out) {
  std::vector<GeometryId> ids;
  std::vector<double> fractions;
  std::vector<Vector3> positions, normals;
  for (const ShapeCastHit& hit : hits) {
    ids.push_back(hit.hit);
    fractions.push_back(hit.fraction);
    positions.push_back(hit.position);
    normals.push_back(hit.normal);
  }
  EncodeHits(ids, out);
  EncodeColumn(fractions, out->mutable_fractions());
  EncodeColumn(positions, out->mutable_positions());
  EncodeColumn(normals, out->mutable_normals());
}

Result<std::vector<ShapeCastHit>> DecodeShapeCastHits(const v1::CastShapeResponse& response) {
  const Result<std::vector<GeometryId>> ids = DecodeHits(response);
  if (!ids.ok()) return ids.status();
  const std::vector<double> fractions = DecodeColumn<double>(response.fractions());
  const std::vector<Vector3> positions = DecodeColumn<Vector3>(response.positions());
  const std::vector<Vector3> normals = DecodeColumn<Vector3>(response.normals());
  if (fractions.size() != ids->size()) return Uneven("fractions");
  if (positions.size() != ids->size()) return Uneven("positions");
  if (normals.size() != ids->size()) return Uneven("normals");
  std::vector<ShapeCastHit> hits(ids->size());
  for (size_t i = 0; i < hits.size(); ++i) hits[i] = {(*ids)[i], fractions[i], positions[i], normals[i]};
  return hits;
}

void EncodeOverlaps(std::span<const std::vector<GeometryId>> overlaps, v1::FindOverlapsResponse* out) {
  std::vector<GeometryId> hits;
  for (const std::vector<GeometryId>& here : overlaps) {
    out->add_hit_counts(static_cast<uint32_t>(here.size()));
    hits.insert(hits.end(), here.begin(), here.end());
  }
  EncodeHits(hits, out);
}

Result<std::vector<std::vector<GeometryId>>> DecodeOverlaps(const v1::FindOverlapsResponse& response) {
  const Result<std::vector<GeometryId>> hits = DecodeHits(response);
  if (!hits.ok()) return hits.status();
  return Split(*hits, response.hit_counts());
}

void EncodeClosest(std::span<const ClosestPoints> closest, v1::ClosestColumns* out) {
  std::vector<GeometryId> ids;
  std::vector<double> distances;
  std::vector<Vector3> first, second, normals;
  for (const ClosestPoints& points : closest) {
    ids.push_back(points.hit);
    distances.push_back(points.distance);
    first.push_back(points.on_query);
    second.push_back(points.on_hit);
    normals.push_back(points.normal);
  }
  EncodeHits(ids, out);
  EncodeColumn(distances, out->mutable_distances());
  EncodeColumn(first, out->mutable_first_points());
  EncodeColumn(second, out->mutable_second_points());
  EncodeColumn(normals, out->mutable_normals());
}

Result<std::vector<ClosestPoints>> DecodeClosest(const v1::ClosestColumns& columns) {
  const Result<std::vector<GeometryId>> ids = DecodeHits(columns);
  if (!ids.ok()) return ids.status();
  const std::vector<double> distances = DecodeColumn<double>(columns.distances());
  const std::vector<Vector3> first = DecodeColumn<Vector3>(columns.first_points());
  const std::vector<Vector3> second = DecodeColumn<Vector3>(columns.second_points());
  const std::vector<Vector3> normals = DecodeColumn<Vector3>(columns.normals());
  if (distances.size() != ids->size()) return Uneven("distances");
  if (first.size() != ids->size()) return Uneven("first_points");
  if (second.size() != ids->size()) return Uneven("second_points");
  if (normals.size() != ids->size()) return Uneven("normals");
  std::vector<ClosestPoints> closest(ids->size());
  for (size_t i = 0; i < closest.size(); ++i) closest[i] = {(*ids)[i], distances[i], first[i], second[i], normals[i]};
  return closest;
}

void EncodeContacts(std::span<const EntityContact> contacts, v1::GetContactsResponse* out) {
  for (const EntityContact& contact : contacts) {
    v1::EntityContact* message = out->add_contacts();
    message->set_other_id(contact.other.packed());
    message->set_is_sensor(contact.is_sensor);
    for (const EventContactPoint& point : contact.points) EncodePoint(point, message->add_points());
  }
}

std::vector<EntityContact> DecodeContacts(const v1::GetContactsResponse& response) {
  std::vector<EntityContact> contacts;
  for (const v1::EntityContact& message : response.contacts()) {
    EntityContact contact{EntityId::FromPacked(message.other_id()), message.is_sensor(), {}};
    for (const v1::ContactPoint& point : message.points()) contact.points.push_back(DecodePoint(point));
    contacts.push_back(std::move(contact));
  }
  return contacts;
}

}  // namespace genphys

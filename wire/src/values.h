#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "genphys/capabilities.h"
#include "genphys/math.h"
#include "genphys/status.h"
#include "genphys/v1/types.pb.h"

// Values that entities, commands, events and worlds share, in both directions.

namespace genphys {

static_assert(std::endian::native == std::endian::little, "columns are copied as they lie");

inline Vector3 DecodeVector(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

inline void EncodeVector(const Vector3& v, v1::Vector3* out) {
  out->set_x(v.x());
  out->set_y(v.y());
  out->set_z(v.z());
}

inline Quaternion DecodeQuaternion(const v1::Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

inline void EncodeQuaternion(const Quaternion& q, v1::Quaternion* out) {
  out->set_w(q.w());
  out->set_x(q.x());
  out->set_y(q.y());
  out->set_z(q.z());
}

/// What is unset is the origin and the identity.
inline Pose DecodePose(const v1::Pose& pose) {
  Pose decoded;
  if (pose.has_position()) decoded.position = DecodeVector(pose.position());
  if (pose.has_orientation()) decoded.orientation = DecodeQuaternion(pose.orientation());
  return decoded;
}

inline void EncodePose(const Pose& pose, v1::Pose* out) {
  EncodeVector(pose.position, out->mutable_position());
  EncodeQuaternion(pose.orientation, out->mutable_orientation());
}

/// INVALID_VALUE "id" unless what is to be created leaves its id to the server.
inline Status CheckNoId(uint64_t id) {
  if (id == 0) return absl::OkStatus();
  return Refuse(Reason::kInvalidValue, "id", "what is created is given its id by the server: leave it zero");
}

/// The rows of a column of fixed width; bytes after the last whole row are left out.
template <typename Row>
std::vector<Row> DecodeColumn(std::string_view bytes) {
  std::vector<Row> rows(bytes.size() / sizeof(Row));
  // Rows are plain numbers; the cast says so to a compiler that sees their constructors.
  if (!rows.empty()) std::memcpy(static_cast<void*>(rows.data()), bytes.data(), rows.size() * sizeof(Row));
  return rows;
}

template <typename Row>
void EncodeColumn(const std::vector<Row>& rows, std::string* out) {
  out->assign(reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(Row));
}

static_assert(sizeof(Vector3) == 3 * sizeof(double), "a column of vectors has no padding");

}  // namespace genphys

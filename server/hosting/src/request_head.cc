#include "genphys/hosting/request_head.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>

namespace genphys {
namespace {

enum WireType : uint32_t { kVarint = 0, kFixed64 = 1, kLengthDelimited = 2, kFixed32 = 5 };

// Takes a varint off the front of `bytes`; nothing when it is cut off or longer than ten bytes.
std::optional<uint64_t> TakeVarint(std::string_view& bytes) {
  constexpr size_t kVarintBytesMax = 10;
  uint64_t value = 0;
  for (size_t i = 0; i < std::min(bytes.size(), kVarintBytesMax); ++i) {
    const auto byte = static_cast<unsigned char>(bytes[i]);
    value |= uint64_t{byte & 0x7fu} << (7 * i);
    if ((byte & 0x80u) == 0) {
      bytes.remove_prefix(i + 1);
      return value;
    }
  }
  return std::nullopt;
}

// Takes the payload of a field off the front of `bytes`; nothing when it is cut off or of a type that proto3 lacks.
std::optional<std::string_view> TakePayload(uint32_t wire_type, std::string_view& bytes) {
  uint64_t size = 0;
  switch (wire_type) {
    case kVarint:
      return TakeVarint(bytes) ? std::optional<std::string_view>("") : std::nullopt;
    case kFixed64:
      size = 8;
      break;
    case kFixed32:
      size = 4;
      break;
    case kLengthDelimited: {
      const std::optional<uint64_t> length = TakeVarint(bytes);
      if (!length) return std::nullopt;
      size = *length;
      break;
    }
    default:
      return std::nullopt;
  }
  if (size > bytes.size()) return std::nullopt;
  const std::string_view payload = bytes.substr(0, size);
  bytes.remove_prefix(size);
  return payload;
}

// Calls `visit(number, payload)` for each length-delimited field. False when the bytes are no protobuf message.
template <typename Visit>
bool ForEachField(std::string_view bytes, Visit visit) {
  while (!bytes.empty()) {
    const std::optional<uint64_t> tag = TakeVarint(bytes);
    if (!tag || *tag > UINT32_MAX) return false;
    const auto number = static_cast<uint32_t>(*tag >> 3);
    const auto wire_type = static_cast<uint32_t>(*tag & 7);
    const std::optional<std::string_view> payload = TakePayload(wire_type, bytes);
    if (number == 0 || !payload) return false;
    if (wire_type == kLengthDelimited) visit(number, *payload);
  }
  return true;
}

}  // namespace

RequestHeadFields RequestHeadFields::Of(const google::protobuf::Descriptor& request) {
  const auto number = [&](const char* name) {
    const google::protobuf::FieldDescriptor* const field = request.FindFieldByName(name);
    return field == nullptr ? 0 : static_cast<uint32_t>(field->number());
  };
  const uint32_t world = number("world");
  return {
      .world = world != 0 ? world : number("name"), .request_id = number("request_id"), .commands = number("commands")};
}

std::optional<RequestHead> ScanRequestHead(const RequestHeadFields& fields, std::string_view bytes) {
  RequestHead head;
  const bool good = ForEachField(bytes, [&](uint32_t number, std::string_view payload) {
    // A field that comes twice counts as the last one, as it does for every decoder.
    if (number == fields.world) head.world = payload;
    if (number == fields.request_id) head.request_id = payload;
    if (number == fields.commands) head.has_commands = true;
  });
  return good ? std::optional(head) : std::nullopt;
}

std::optional<std::vector<std::string_view>> ScanPayloads(uint32_t number, std::string_view bytes) {
  std::vector<std::string_view> payloads;
  const bool good = ForEachField(bytes, [&](uint32_t found, std::string_view payload) {
    if (found == number) payloads.push_back(payload);
  });
  return good ? std::optional(std::move(payloads)) : std::nullopt;
}

}  // namespace genphys

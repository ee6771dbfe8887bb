#pragma once
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Descriptor;
}

namespace genphys {

/// What the front reads of a request; views into its bytes.
struct RequestHead {
  std::string_view world;       // as sent: nobody checked its form
  std::string_view request_id;  // empty: none
  bool has_commands = false;
};

/// Where a type of request has them; zero where it has not.
struct RequestHeadFields {
  uint32_t world = 0;
  uint32_t request_id = 0;
  uint32_t commands = 0;

  /// Of the fields called "world" (or else "name"), "request_id" and "commands".
  static RequestHeadFields Of(const google::protobuf::Descriptor& request);
};

/// Finds them in an encoded request without decoding it, at the cost of a step per top-level field. Nothing when the
/// bytes are no protobuf message.
std::optional<RequestHead> ScanRequestHead(const RequestHeadFields& fields, std::string_view bytes);

/// What the length-delimited field `number` of an encoded message holds, each time that it comes; views into `bytes`.
/// Nothing when the bytes are no protobuf message.
std::optional<std::vector<std::string_view>> ScanPayloads(uint32_t number, std::string_view bytes);

}  // namespace genphys

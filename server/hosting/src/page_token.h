#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace genphys {

/// What a page has at most when the request leaves it to the server.
inline constexpr int kPageSizeDefault = 100;
/// A page ends with the element that reaches this size, so that it stays below what gRPC clients accept by default.
inline constexpr size_t kPageBytesMax = 1 << 20;

/// `page_size` of a request, or the default.
inline size_t PageSize(int page_size) { return static_cast<size_t>(page_size > 0 ? page_size : kPageSizeDefault); }

/// An opaque token that stands for `place`.
std::string EncodePageToken(std::string_view place);
/// The place, or nothing if this is no token of ours.
std::optional<std::string> DecodePageToken(std::string_view token);

}  // namespace genphys

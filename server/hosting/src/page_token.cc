#include "page_token.h"

namespace genphys {
namespace {

constexpr std::string_view kDigits = "0123456789abcdef";

}  // namespace

std::string EncodePageToken(std::string_view place) {
  std::string token;
  for (const char byte : place) {
    const auto value = static_cast<unsigned char>(byte);
    token += kDigits[value >> 4];
    token += kDigits[value & 15];
  }
  return token;
}

std::optional<std::string> DecodePageToken(std::string_view token) {
  if (token.empty() || token.size() % 2 != 0) return std::nullopt;
  std::string place;
  for (size_t i = 0; i < token.size(); i += 2) {
    const size_t high = kDigits.find(token[i]), low = kDigits.find(token[i + 1]);
    if (high == std::string_view::npos || low == std::string_view::npos) return std::nullopt;
    place += static_cast<char>(high << 4 | low);
  }
  return place;
}

}  // namespace genphys

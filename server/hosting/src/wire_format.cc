#include "wire_format.h"

namespace genphys {
namespace {

constexpr uint64_t kVarint = 0;
constexpr uint64_t kLengthDelimited = 2;

void AppendVarint(uint64_t value, std::string& out) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<char>(value | 0x80));
  out.push_back(static_cast<char>(value));
}

void AppendTag(int number, uint64_t wire_type, std::string& out) {
  AppendVarint(static_cast<uint64_t>(number) << 3 | wire_type, out);
}

}  // namespace

void AppendFieldHeader(int number, size_t size, std::string& out) {
  AppendTag(number, kLengthDelimited, out);
  AppendVarint(size, out);
}

void AppendField(int number, std::string_view payload, std::string& out) {
  AppendFieldHeader(number, payload.size(), out);
  out += payload;
}

void AppendVarintField(int number, uint64_t value, std::string& out) {
  AppendTag(number, kVarint, out);
  AppendVarint(value, out);
}

}  // namespace genphys

#include "genphys/wire/wire_format.h"

#include <google/protobuf/io/coded_stream.h>

namespace genphys {
namespace {

using google::protobuf::io::CodedOutputStream;

enum class WireType : uint64_t { kVarint = 0, kLengthDelimited = 2 };

// A tag and a size, or a tag and a value.
constexpr size_t kTwoVarintsMax = 20;

uint64_t TagOf(int number, WireType type) { return static_cast<uint64_t>(number) << 3 | static_cast<uint64_t>(type); }

char* WriteVarint(uint64_t value, char* to) {
  return reinterpret_cast<char*>(CodedOutputStream::WriteVarint64ToArray(value, reinterpret_cast<uint8_t*>(to)));
}

void Append(uint64_t tag, uint64_t value, std::string& out) {
  char bytes[kTwoVarintsMax];
  const char* const end = WriteVarint(value, WriteVarint(tag, bytes));
  out.append(bytes, static_cast<size_t>(end - bytes));
}

}  // namespace

size_t FieldHeaderSize(int number, size_t size) {
  return CodedOutputStream::VarintSize64(TagOf(number, WireType::kLengthDelimited)) +
         CodedOutputStream::VarintSize64(size);
}

char* WriteFieldHeader(int number, size_t size, char* to) {
  return WriteVarint(size, WriteVarint(TagOf(number, WireType::kLengthDelimited), to));
}

void AppendFieldHeader(int number, size_t size, std::string& out) {
  Append(TagOf(number, WireType::kLengthDelimited), size, out);
}

void AppendField(int number, std::string_view payload, std::string& out) {
  AppendFieldHeader(number, payload.size(), out);
  out += payload;
}

void AppendVarintField(int number, uint64_t value, std::string& out) {
  Append(TagOf(number, WireType::kVarint), value, out);
}

}  // namespace genphys

#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace genphys {

/// Appends the header of a length-delimited field to an encoded message: its payload of `size` bytes comes next.
void AppendFieldHeader(int number, size_t size, std::string& out);
/// Appends a whole length-delimited field.
void AppendField(int number, std::string_view payload, std::string& out);
/// Appends an unsigned integer field.
void AppendVarintField(int number, uint64_t value, std::string& out);

}  // namespace genphys

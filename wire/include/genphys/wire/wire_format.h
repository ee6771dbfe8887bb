#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

// Pieces of encoded messages, for those that are put together without an object of the whole.

namespace genphys {

/// Bytes of the header of a length-delimited field with a payload of `size` bytes.
size_t FieldHeaderSize(int number, size_t size);
/// Writes that header to `to`, and returns where it ends: the payload comes next.
char* WriteFieldHeader(int number, size_t size, char* to);

/// Appends the header of a length-delimited field to an encoded message: its payload of `size` bytes comes next.
void AppendFieldHeader(int number, size_t size, std::string& out);
/// Appends a whole length-delimited field.
void AppendField(int number, std::string_view payload, std::string& out);
/// Appends an unsigned integer field.
void AppendVarintField(int number, uint64_t value, std::string& out);

}  // namespace genphys

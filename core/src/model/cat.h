#pragma once
#include <charconv>
#include <string>
#include <string_view>
#include <type_traits>

namespace genphys {

/// Appends `part` to `text`: characters as they are, numbers in their shortest exact form.
template <typename T>
void Append(std::string& text, const T& part) {
  if constexpr (std::is_arithmetic_v<T>) {
    char digits[32];
    const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, part);
    text.append(digits, end.ptr);
  } else {
    text.append(std::string_view(part));
  }
}

/// The parts in one string. Debian's abseil has a string_view of its own, so its StrCat takes none of ours.
template <typename... Parts>
std::string Cat(const Parts&... parts) {
  std::string text;
  (Append(text, parts), ...);
  return text;
}

}  // namespace genphys

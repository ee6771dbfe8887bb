#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace genphys {

/// Immutable bytes together with what keeps them alive; copies share them.
struct Bytes {
  std::string_view view;
  std::shared_ptr<const void> owner;
};

inline Bytes MakeBytes(std::string bytes) {
  auto owner = std::make_shared<const std::string>(std::move(bytes));
  return {*owner, owner};
}

/// `size` bytes that `write(char*)` fills.
template <typename Write>
Bytes MakeBytes(size_t size, Write write) {
  auto owner = std::make_shared_for_overwrite<char[]>(size);
  write(owner.get());
  return {std::string_view(owner.get(), size), owner};
}

/// One encoded message in pieces that follow each other, so that what many receive is encoded once.
using EncodedMessage = std::vector<Bytes>;

/// Bytes of all its pieces.
inline size_t SizeOf(const EncodedMessage& message) {
  size_t size = 0;
  for (const Bytes& piece : message) size += piece.view.size();
  return size;
}

/// All its pieces in one.
inline std::string Joined(const EncodedMessage& message) {
  std::string whole;
  whole.reserve(SizeOf(message));
  for (const Bytes& piece : message) whole += piece.view;
  return whole;
}

}  // namespace genphys

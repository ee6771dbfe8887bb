#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "genphys/math.h"

namespace genphys {

static_assert(std::endian::native == std::endian::little, "serialised numbers are little-endian");

/// Appends plain values to a byte string; equal values give equal bytes.
class ByteWriter {
 public:
  explicit ByteWriter(std::string& bytes) : bytes_(bytes) {}

  template <typename T>
  requires std::is_arithmetic_v<T>
  void Put(T value) { Append(&value, sizeof value); }
  void Put(std::string_view text) {
    Put(uint64_t{text.size()});
    Append(text.data(), text.size());
  }
  template <typename Derived>
  void Put(const Eigen::PlainObjectBase<Derived>& matrix) {
    Append(matrix.data(), sizeof(typename Derived::Scalar) * static_cast<size_t>(matrix.size()));
  }
  void Put(const Quaternion& q) { Put(ToColumn(q)); }
  template <typename T>
  void Put(const std::optional<T>& value) {
    Put(value.has_value());
    if (value) Put(*value);
  }
  /// A vector of plain numbers, with its length.
  template <typename T>
  requires std::is_arithmetic_v<T>
  void PutColumn(const std::vector<T>& column) {
    Put(uint64_t{column.size()});
    Append(column.data(), sizeof(T) * column.size());
  }

 private:
  void Append(const void* data, size_t size) { bytes_.append(static_cast<const char*>(data), size); }

  std::string& bytes_;
};

}  // namespace genphys

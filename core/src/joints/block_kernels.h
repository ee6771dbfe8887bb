#pragma once
#include <cmath>
#include <cstddef>

namespace genphys {

/// How many rows a block has. Three, which hold two points together, are by far the most common: `kKnown` tells the
/// compiler, which then leaves the counting out. Zero: any number.
template <size_t kKnown>
class RowCount {
 public:
  explicit constexpr RowCount(size_t count) : count_(count) {}
  constexpr operator size_t() const { return kKnown != 0 ? kKnown : count_; }

 private:
  size_t count_;
};

/// Calls use(count) with the RowCount that fits best.
template <typename Use>
decltype(auto) WithRowCount(size_t count, Use&& use) {
  return count == 3 ? use(RowCount<3>(count)) : use(RowCount<0>(count));
}

/// Replaces the lower triangle of a symmetric block, row by row `stride` apart, by L D L^T of it: the ones of L are
/// left out and D is kept as its reciprocals. False: it is not positive definite, as far as numbers tell.
template <size_t kKnown>
bool FactorBlock(RowCount<kKnown> count, double* block, size_t stride) {
  for (size_t c = 0; c < count; ++c) {
    const double pivot = block[c * stride + c];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    const double reciprocal = 1 / pivot;
    block[c * stride + c] = reciprocal;
    for (size_t r = count; r-- > c + 1;) {
      // From the last row on, so that those above are still undivided.
      const double scaled = block[r * stride + c] * reciprocal;
      for (size_t k = c + 1; k <= r; ++k) block[r * stride + k] -= scaled * block[k * stride + c];
      block[r * stride + c] = scaled;
    }
  }
  return true;
}

/// Divides one row of a block below that of FactorBlock() by it; `undivided` is what it was before D, but after L.
template <size_t kKnown>
void DivideRow(RowCount<kKnown> count, const double* factors, size_t stride, double* row, double* undivided) {
  for (size_t q = 0; q < count; ++q) {
    double value = row[q];
    for (size_t k = 0; k < q; ++k) value -= undivided[k] * factors[q * stride + k];
    undivided[q] = value;
    row[q] = value * factors[q * stride + q];
  }
}

/// The product of two rows.
template <size_t kKnown>
double DotRows(RowCount<kKnown> count, const double* a, const double* b) {
  double sum = 0;
  for (size_t k = 0; k < count; ++k) sum += a[k] * b[k];
  return sum;
}

/// Solves L x = `values` in place, of the factors of FactorBlock().
template <size_t kKnown>
void SubstituteForwards(RowCount<kKnown> count, const double* factors, size_t stride, double* values) {
  for (size_t p = 1; p < count; ++p) {
    for (size_t q = 0; q < p; ++q) values[p] -= factors[p * stride + q] * values[q];
  }
}

/// Solves L^T x = `values` in place.
template <size_t kKnown>
void SubstituteBackwards(RowCount<kKnown> count, const double* factors, size_t stride, double* values) {
  for (size_t p = count; p-- > 1;) {
    for (size_t q = 0; q < p; ++q) values[q] -= factors[p * stride + q] * values[p];
  }
}

}  // namespace genphys

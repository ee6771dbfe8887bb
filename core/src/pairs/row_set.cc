#include "genphys/row_set.h"

namespace genphys {

void RowSet::Add(const RowSet& others) {
  if (words_.size() < others.words_.size()) words_.resize(others.words_.size());
  for (size_t i = 0; i < others.words_.size(); ++i) words_[i] |= others.words_[i];
}

void RowSet::AddAll(uint32_t rows) {
  if (rows == 0) return;
  const size_t last = (rows - 1) / kRowsPerWord;
  if (words_.size() <= last) words_.resize(last + 1);
  for (size_t i = 0; i < last; ++i) words_[i] = ~uint64_t{0};
  words_[last] |= ~uint64_t{0} >> (kRowsPerWord - 1 - (rows - 1) % kRowsPerWord);
}

}  // namespace genphys

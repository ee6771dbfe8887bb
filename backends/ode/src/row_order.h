#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace genphys::ode_backend {

/// In which order the iterative solver of ODE takes its rows.
///
/// It begins with those that only numbers bound, such as the normals of contacts, and then takes those that these
/// bound, such as friction, and shuffles all after every eighth sweep, for which it draws each swap. Rows in any order
/// come sooner to where no body overlaps, and friction that has the last word to where nothing creeps: walls and
/// pyramids of hundreds of boxes creep by a tenth of what they did. So it is told to mix them, and for a last sweep
/// to take friction after all that bounds it.
class RowOrder {
 public:
  /// Of one solve: `free` rows that only numbers bound, `bounded` ones, and how many sweeps there will be. `draw` is
  /// where random numbers come from, any 32 bits.
  void Begin(size_t free, size_t bounded, uint32_t sweeps, uint32_t (*draw)());

  /// With which of the first `count` rows the last of them is swapped: asked for 2, 3, ... up to all, and from 2 on
  /// again. Of more rows than there are it leaves those as they are.
  int PlaceOfLast(int count);

 private:
  void Shuffle();
  void Arrange();
  void FindSwaps();

  uint32_t sweeps_left_ = 0;  // from the last shuffle on
  uint32_t (*draw_)() = nullptr;
  std::vector<uint32_t> free_rows_;     // in the order in which they are to be taken
  std::vector<uint32_t> bounded_rows_;  // the same
  std::vector<uint32_t> present_;       // by place, which row ODE has there
  std::vector<uint32_t> wanted_;
  std::vector<uint32_t> place_;  // by row
  std::vector<uint32_t> swaps_;  // by place
};

}  // namespace genphys::ode_backend

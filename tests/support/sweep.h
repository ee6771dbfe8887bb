#pragma once

namespace genphys {

/// Of the cases of a long sweep every so many-th is tried: all of them, or, under a sanitizer, with which each takes
/// ten times as long, enough to go through every kind of code that the sweep reaches.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kSweepStride = 11;
#else
inline constexpr int kSweepStride = 1;
#endif

/// Cells along each side of a mesh of a million triangles, or of one that takes as long to make under a sanitizer.
inline constexpr int kManyCells = kSweepStride == 1 ? 707 : 250;

}  // namespace genphys

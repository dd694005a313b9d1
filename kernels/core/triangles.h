// Triangles by the numbers of their corners.
#pragma once

#include <algorithm>
#include <array>

namespace overtet {

// The same for a triangle however it is turned or flipped: a key.
template <class T>
std::array<T, 3> sorted(std::array<T, 3> f) {
  std::sort(f.begin(), f.end());
  return f;
}

// The same however it is turned, its orientation kept: the smallest corner comes first.
template <class T>
std::array<T, 3> rotated(std::array<T, 3> f) {
  if (f[0] <= f[1] && f[0] <= f[2]) return f;
  if (f[1] <= f[0] && f[1] <= f[2]) return {f[1], f[2], f[0]};
  return {f[2], f[0], f[1]};
}

}  // namespace overtet

// The faces and edges of a tet (a, b, c, d), by the numbers 0 .. 3 of its corners. A tet is positive when
// det(b - a, c - a, d - a) > 0 (overtet/types.h).
#pragma once

#include <array>
#include <type_traits>

namespace overtet {

// Face k is the one without corner k. Of a positive tet: counter-clockwise seen from outside.
inline constexpr int kTetFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

// The same faces, turned over: counter-clockwise seen from corner k, so that (kTetInnerFace[k], k) is an even
// permutation of the tet.
inline constexpr int kTetInnerFace[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};

// The corners of these faces, of a tet that is an array or the row of a matrix.
template <class Tet>
auto tet_face(const Tet& tet, int k) {
  const auto& [a, b, c] = kTetFace[k];
  return std::array<std::remove_cvref_t<decltype(tet[0])>, 3>{tet[a], tet[b], tet[c]};
}
template <class Tet>
auto tet_inner_face(const Tet& tet, int k) {
  const auto& [a, b, c] = kTetInnerFace[k];
  return std::array<std::remove_cvref_t<decltype(tet[0])>, 3>{tet[a], tet[b], tet[c]};
}

// Edges, the smaller corner first, in lexicographic order: edge 5 - e is opposite edge e.
inline constexpr int kTetEdge[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

}  // namespace overtet

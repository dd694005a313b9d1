// The Delaunay tets of a complex's points, which of its facets are faces of them, and which tets the others
// pass through.
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "kernels/core/triangles.h"
#include "kernels/delaunay/delaunay.h"
#include "kernels/parallel/raw_vector.h"
#include "overtet/result.h"
#include "src/cdt/tetgen.h"
#include "src/cdt/tuning.h"

namespace overtet {

using Tet = std::array<Index, 4>;
using Triple = std::array<Index, 3>;

// True when b is an even permutation of a. pre: b is a permutation of a.
bool same_turn(const Triple& a, const Triple& b);

// Finds triangles by their corners.
class TriangleTable {
 public:
  // vertices: more than any corner. The list must stay where it is.
  TriangleTable(Index vertices, const std::vector<Triple>& triangles);
  // Its number, or -1.
  Index find(const Triple& f) const;

 private:
  const std::vector<Triple>& triangles_;
  RawVector<Index> start_;
  RawVector<Index> items_;
};

struct DelaunayMatch {
  explicit DelaunayMatch(const Plc& complex) : plc(complex) {}

  // Fills everything but crossed. The same on any number of threads. begun: has the complex's first points,
  // then the `free` last ones.
  std::optional<Error> run(const RunContext& context, DelaunayBuilder begun = {}, Index free = 0);

  // The tets that each missing facet passes through, by facet.
  void find_crossed_tets();
  // Whether missing facets, or some of them that are looked at, pass through so many that it is better to
  // leave them to TetGen.
  bool crosses_many() const;

  const Plc& plc;
  RawVector<Tet> tet, next;    // as TetArrays
  RawVector<Tet> facet_on;     // per tet: the facet on the face opposite to each corner, or -1
  std::vector<char> replaced;  // per tet: it is no more (for those who change them)
  std::vector<Triple> facets;  // the complex's
  std::vector<Index> missing;  // facets that are no faces
  std::vector<std::pair<Index, Index>> crossed;  // tet, missing facet
};

// Tets that fill what the facets enclose, and perhaps more around it.
struct Filling {
  const RawVector<Tet>&tet, &next, &facet_on;  // as in DelaunayMatch
  const std::vector<Triple>& facets;           // the complex's, then parts of those that had to be split
  const std::vector<Index>& source;            // the complex's facet of each
  const std::vector<Eigen::Vector3d>& added;   // points; their numbers follow those of the complex
  const Index needed;                          // so many of the complex's must be there
};

// The result without the tets that can be reached from outside without passing through a facet, and without
// those that have been replaced. Errors: unsolved where one of the points to be kept is left out.
Result<TetgenResult> without_outside(const Plc& plc, const Filling& filling,
                                     const std::vector<char>& replaced);

}  // namespace overtet

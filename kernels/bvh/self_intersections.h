// All pairs of faces of a surface that intersect, decided exactly.
//
// "Intersect" has the meaning of CGAL::Polygon_mesh_processing::self_intersections: faces without a
// common vertex in any point, faces with one common vertex beyond it, faces with a common edge when they
// are coplanar and overlap, faces with the same three vertices always.
//
// Nearly all pairs of overlapping boxes are faces around one vertex. Vertices whose faces lie beside each
// other when seen from some direction are therefore found first, once each, and their pairs left out; all
// others are decided by predicates. Answers are exact either way.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/bvh/bvh.h"
#include "overtet/types.h"

namespace overtet {

using FacePair = std::pair<Index, Index>;  // first < second

struct SelfIntersectionOptions {
  bool stop_at_first = false;  // return as soon as there are some pairs (which ones: same on any threads)
  std::vector<std::uint8_t> active;  // #F or empty; only pairs with an active face (1) are looked for
};

// True when every coordinate is finite. A NaN makes every comparison false and so every test "clean":
// check first, always.
bool all_finite(const VertexMatrix& V);

// Sorted, first < second.
// pre: all_finite(V), indices valid.
std::vector<FacePair> find_self_intersections(const VertexMatrix& V, const TriangleMatrix& F,
                                              const SelfIntersectionOptions& options = {});

// The same with a tree that was built for F and refitted to V (with or without padding). Changes the
// tree's active mask only when the options name one.
std::vector<FacePair> find_self_intersections(const VertexMatrix& V, const TriangleMatrix& F,
                                              TriangleBvh& bvh, const SelfIntersectionOptions& options = {});

}  // namespace overtet

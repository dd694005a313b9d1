// The surface on its way through the steps, and what they ask of it. Half-edges as in src/mesh/topology.h;
// the surface is what a clean-up leaves: oriented, with borders.
#pragma once

#include <vector>

#include "kernels/parallel/raw_vector.h"
#include "overtet/cleanup.h"
#include "overtet/types.h"

namespace overtet {

struct WorkingSurface {
  Surface surface;
  // Numbers of the given surface, -1: new. Never empty.
  std::vector<Index> vertex_of, face_of;

  // Takes over a clean-up of `surface`.
  void become(Cleanup&& cleaned);
};

// The half-edges that leave each vertex: at(v), ascending.
class Incidence {
 public:
  Incidence(Index vertices, const TriangleMatrix& F);
  // One pair of iterators.
  struct Range {
    const Index *first, *last;
    const Index* begin() const { return first; }
    const Index* end() const { return last; }
  };
  Range at(Index v) const { return {items_.data() + start_[v], items_.data() + start_[v + 1]}; }
  // Whether a face runs along the half-edge the other way.
  bool has_twin(const TriangleMatrix& F, Index h) const;

 private:
  RawVector<Index> start_, items_;
};

// Half-edges without a twin, ascending.
std::vector<Index> border_half_edges(const TriangleMatrix& F, const Incidence& incidence);

// Closed chains of them, by their smallest half-edge. A chain that passes through a vertex twice, or does not
// close, is not there.
std::vector<std::vector<Index>> border_loops(const TriangleMatrix& F, const std::vector<Index>& border);

}  // namespace overtet

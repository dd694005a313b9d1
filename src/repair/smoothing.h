// Smooth positions for a few vertices of a surface, the others held. Internal to src/repair.
#pragma once

#include <vector>

#include "overtet/types.h"
#include "src/mesh/topology.h"

namespace overtet {

// The vertices that share an edge with each vertex, in one array.
class VertexRings {
 public:
  VertexRings(Index vertices, const TriangleMatrix& F);
  struct Range {
    const Index *first, *last;
    const Index* begin() const { return first; }
    const Index* end() const { return last; }
    Index size() const { return static_cast<Index>(last - first); }
  };
  Range operator()(Index v) const { return {next_.data() + start_[v], next_.data() + start_[v + 1]}; }

  // `seeds` and all vertices at most `rings` edges away, sorted. scratch: #V zeros, left as zeros.
  std::vector<Index> grown(const std::vector<Index>& seeds, int rings, std::vector<char>& scratch) const;

 private:
  std::vector<Index> start_, next_;
};

enum class Smoothing {
  membrane,   // every vertex at the weighted mean of its neighbours: as little area as possible
  thin_plate  // squared distances to these means as small as possible: bends without a kink at the rim
};

// Values for the vertices `free` (sorted) that continue those of all others smoothly: free.size() x 3. With
// values = V: positions. part: of each free vertex, 0 to 1, for the membrane: how strongly it is drawn to the
// mean of its neighbours (1) rather than to its own value (0); small parts remove kinks and keep the shape.
// Weights are one over the edges' lengths in V, so that vertices slide little where V is flat.
// Empty when a whole component is free, or nothing can be solved for.
VertexMatrix smoothed(const VertexMatrix& V, const VertexMatrix& values, const VertexRings& rings,
                      const std::vector<Index>& free, Smoothing kind, const std::vector<float>& part = {});

}  // namespace overtet

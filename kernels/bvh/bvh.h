// The tree of the boxes of a surface's faces (see box_tree.h): items are faces.
#pragma once

#include "kernels/bvh/box_tree.h"
#include "overtet/types.h"

namespace overtet {

class TriangleBvh : public BoxTree {
 public:
  TriangleBvh() = default;
  // pre: indices of F are valid, V is finite. O(#F log #F), parallel.
  TriangleBvh(const VertexMatrix& V, const TriangleMatrix& F) { build(V, F); }
  void build(const VertexMatrix& V, const TriangleMatrix& F);
  Index faces() const { return size(); }

  // New positions of the same faces.
  void refit(const VertexMatrix& V, const TriangleMatrix& F);
};

}  // namespace overtet

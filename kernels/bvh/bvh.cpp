#include "kernels/bvh/bvh.h"

#include <algorithm>

#include "kernels/core/assertions.h"
#include "kernels/core/indices.h"

namespace overtet {

namespace {

struct FaceBoxes {
  const double* points;
  const Index* faces;

  Box operator()(Index f) const {
    const Index* face = faces + 3 * std::int64_t{f};
    const double *p = points + 3 * std::int64_t{face[0]}, *q = points + 3 * std::int64_t{face[1]},
                 *r = points + 3 * std::int64_t{face[2]};
    Box box;
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(std::min(p[k], q[k]), r[k]);
      box.high[k] = std::max(std::max(p[k], q[k]), r[k]);
    }
    return box;
  }
};

}  // namespace

void TriangleBvh::build(const VertexMatrix& V, const TriangleMatrix& F) {
  OVERTET_EXPECTS(V.allFinite() && all_below(F, V.rows()));
  BoxTree::build(static_cast<Index>(F.rows()), FaceBoxes{V.data(), F.data()});
}

void TriangleBvh::refit(const VertexMatrix& V, const TriangleMatrix& F) {
  BoxTree::refit(FaceBoxes{V.data(), F.data()});
}

}  // namespace overtet

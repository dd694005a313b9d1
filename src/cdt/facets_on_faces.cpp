#include "src/cdt/facets_on_faces.h"

#include "kernels/core/tet_tables.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/cdt/delaunay_match.h"

namespace overtet {

std::vector<std::array<Index, 4>> facets_on_faces(const TetgenResult& tets) {
  std::vector<Triple> facets;
  facets.reserve(static_cast<std::size_t>(tets.facets.rows()));
  for (Index i = 0; i < tets.facets.rows(); ++i)
    facets.push_back({tets.facets(i, 0), tets.facets(i, 1), tets.facets(i, 2)});
  const TriangleTable table(static_cast<Index>(tets.V.rows()), facets);
  std::vector<std::array<Index, 4>> found(static_cast<std::size_t>(tets.T.rows()));
  parallel_for(tets.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<Index>(begin); t < end; ++t)
      for (int k = 0; k < 4; ++k) found[t][k] = table.find(tet_face(tets.T.row(t), k));
  });
  return found;
}

}  // namespace overtet

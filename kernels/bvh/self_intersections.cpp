#include "kernels/bvh/self_intersections.h"

#include <algorithm>
#include <cmath>

#include "kernels/predicates/predicates.h"

namespace overtet {

bool all_finite(const VertexMatrix& V) {
  const double* x = V.data();
  const std::int64_t n = V.size();
  return parallel_reduce(
      n, std::int64_t{1} << 16, true,
      [&](std::int64_t begin, std::int64_t end) {
        bool finite = true;
        for (std::int64_t i = begin; i < end; ++i) finite = finite && std::isfinite(x[i]);
        return finite;
      },
      [](bool a, bool b) { return a && b; });
}

std::vector<FacePair> find_self_intersections(const VertexMatrix& V, const TriangleMatrix& F,
                                              const SelfIntersectionOptions& options) {
  TriangleBvh bvh(V, F);
  return find_self_intersections(V, F, bvh, options);
}

std::vector<FacePair> find_self_intersections(const VertexMatrix& V, const TriangleMatrix& F,
                                              TriangleBvh& bvh, const SelfIntersectionOptions& options) {
  if (!options.active.empty()) bvh.set_active(options.active);
  const double* points = V.data();
  const Index* faces = F.data();
  const auto visit = [&](Index f, Index g, std::vector<FacePair>& out) {
    if (faces_intersect(points, faces + 3 * std::int64_t{f}, faces + 3 * std::int64_t{g}))
      out.emplace_back(f, g);
  };
  std::vector<FacePair> pairs;
  if (options.stop_at_first)
    bvh.find_self_pair<FacePair>(pairs, visit);
  else
    pairs = bvh.collect_self_pairs<FacePair>(visit);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<FacePair> still_intersecting(const VertexMatrix& V, const TriangleMatrix& F,
                                         const std::vector<FacePair>& pairs) {
  std::vector<FacePair> out;
  for (const FacePair& pair : pairs)
    if (faces_intersect(V.data(), F.data() + 3 * std::int64_t{pair.first},
                        F.data() + 3 * std::int64_t{pair.second}))
      out.push_back(pair);
  return out;
}

}  // namespace overtet

#include "src/prepare/working_surface.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/mesh/topology.h"

namespace overtet {

void WorkingSurface::become(Cleanup&& cleaned) {
  surface = std::move(cleaned.surface);
  const auto through = [](const std::vector<Index>& step, std::vector<Index>& all) {
    if (step.empty()) return;
    std::vector<Index> now;
    now.reserve(step.size());
    for (const Index i : step) now.push_back(all[i]);
    all = std::move(now);
  };
  through(cleaned.vertex_of, vertex_of);
  through(cleaned.face_of, face_of);
}

Incidence::Incidence(Index vertices, const TriangleMatrix& F) {
  const Index corners = 3 * static_cast<Index>(F.rows());
  group_items(vertices, start_, items_, [&](auto visit) {
    for (Index h = 0; h < corners; ++h) visit(half_edge_source(F, h), h);
  });
}

bool Incidence::has_twin(const TriangleMatrix& F, Index h) const {
  const Index a = half_edge_source(F, h);
  for (const Index g : at(half_edge_target(F, h)))
    if (half_edge_target(F, g) == a) return true;
  return false;
}

std::vector<Index> border_half_edges(const TriangleMatrix& F, const Incidence& incidence) {
  return parallel_collect<Index>(3 * static_cast<std::int64_t>(F.rows()), kLightGrain,
                                 [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
                                   for (auto h = static_cast<Index>(begin); h < end; ++h)
                                     if (!incidence.has_twin(F, h)) out.push_back(h);
                                 });
}

std::vector<std::vector<Index>> border_loops(const TriangleMatrix& F, const std::vector<Index>& border) {
  std::unordered_map<Index, Index> leaving;  // vertex -> its half-edge in the border; -2: it has several
  for (const Index h : border)
    if (const auto [at, is_new] = leaving.try_emplace(half_edge_source(F, h), h); !is_new) at->second = -2;
  std::vector<std::vector<Index>> loops;
  for (const Index first : border) {
    std::vector<Index> loop;
    for (Index h = first; h >= 0;) {
      const auto here = leaving.find(half_edge_source(F, h));
      if (here == leaving.end() || here->second != h) break;  // done before, or crowded
      here->second = -1;
      loop.push_back(h);
      if (half_edge_target(F, h) == half_edge_source(F, first)) {
        loops.push_back(std::move(loop));
        break;
      }
      const auto next = leaving.find(half_edge_target(F, h));
      h = next == leaving.end() ? -1 : next->second;
    }
  }
  return loops;
}

}  // namespace overtet

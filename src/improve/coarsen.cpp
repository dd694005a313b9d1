#include "src/improve/coarsen.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "kernels/core/tuning.h"
#include "src/improve/tuning.h"

namespace overtet {

bool contract_shortest(LocalOperations& work, Index v, const std::vector<Index>& tets, double enough) {
  const TetComplex& mesh = work.mesh();
  static thread_local std::vector<std::pair<double, Index>> ends;
  ends.clear();
  for (const Index t : tets)
    for (const Index w : mesh.tet(t))
      if (w != v) ends.emplace_back((mesh.position(w) - mesh.position(v)).squaredNorm(), w);
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return std::any_of(ends.begin(), ends.end(),
                     [&](const auto& end) { return work.collapse(v, end.second, enough); });
}

std::int64_t coarsen(LocalOperations& work, double enough, Removal how, const RunContext& context) {
  const TetComplex& mesh = work.mesh();
  std::vector<char> stays(mesh.vertex_count(), 0);  // tried in vain, and nothing has changed around it
  std::vector<Index> tets;
  std::int64_t all = 0;
  const auto changed = [&] {
    for (const Index t : work.changed())
      for (const Index u : mesh.tet(t)) stays[u] = 0;
  };
  for (int pass = 0; pass < kMostRounds; ++pass) {
    std::int64_t gone = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (stays[v] || work.fixed(v) || mesh.tet_of(v) < 0) continue;
      if (context.stop()) return all + gone;
      mesh.star(v, tets);
      stays[v] = 1;
      bool removed = contract_shortest(work, v, tets, enough);
      if (!removed && how == Removal::by_all_means) removed = work.remove_vertex(v, enough);
      if (removed) {
        ++gone;
        changed();
      } else if (how == Removal::by_all_means && work.smooth(v, kPays)) {
        changed();
        stays[v] = 1;
      }
    }
    all += gone;
    if (gone * kVerticesPerGone <= mesh.vertex_count()) break;
  }
  return all;
}

}  // namespace overtet

#include "src/improve/refine.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "kernels/core/tuning.h"
#include "src/improve/bad_tets.h"
#include "src/improve/coarsen.h"
#include "src/improve/insert_at.h"
#include "src/improve/tuning.h"

namespace overtet {

std::int64_t refine(LocalOperations& work, double radius_edge, std::span<const char> loose,
                    std::int64_t most_tets, const RunContext& context) {
  const TetComplex& mesh = work.mesh();
  std::vector<char> hopeless(mesh.tet_capacity(), 0);  // tried in vain
  std::int64_t all = 0;
  const auto is_loose = [&](Index v) { return v < static_cast<Index>(loose.size()) && loose[v]; };
  for (int pass = 0; pass < kMostRounds; ++pass) {
    const std::vector<BadTet> bad = bad_tets(mesh, [&](Index t) -> std::optional<double> {
      const auto& c = mesh.tet(t);
      if (hopeless[t] || std::any_of(c.begin(), c.end(), is_loose)) return std::nullopt;
      const double ratio = work.squared_radius_edge(t);
      return ratio > radius_edge * radius_edge ? std::optional(-ratio) : std::nullopt;
    });
    const Insertions done = insert_at(work, bad, hopeless, most_tets, context,
                                      [&](Index t) { return work.insert_circumcentre(t, radius_edge); });
    all += done.count;
    if (done.stopped || done.count * kTetsPerVertex <= mesh.tet_count()) break;
  }
  return all;
}

std::int64_t contract_loose(LocalOperations& work, std::span<const char> loose, double bad,
                            const RunContext& context) {
  const TetComplex& mesh = work.mesh();
  std::int64_t contracted = 0;
  std::vector<Index> tets;
  for (Index v = 0; v < static_cast<Index>(loose.size()); ++v) {
    if (!loose[v] || work.fixed(v)) continue;
    if (context.stop()) return contracted;
    mesh.star(v, tets);
    if (std::none_of(tets.begin(), tets.end(), [&](Index t) { return work.quality(t) < bad; })) continue;
    if (contract_shortest(work, v, tets, bad)) ++contracted;
  }
  return contracted;
}

}  // namespace overtet

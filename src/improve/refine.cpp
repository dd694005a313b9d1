#include "src/improve/refine.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "kernels/core/tuning.h"
#include "src/improve/bad_tets.h"
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
    std::int64_t inserted = 0;
    for (const BadTet& b : bad) {
      if (context.stop()) return all + inserted;
      if (!b.still_in(mesh)) continue;
      if (mesh.tet_count() >= most_tets) return all + inserted;
      if (!work.insert_circumcentre(b.tet)) {
        hopeless[b.tet] = 1;
        continue;
      }
      ++inserted;
      hopeless.resize(mesh.tet_capacity(), 0);
      for (const Index t : work.changed()) hopeless[t] = 0;
    }
    all += inserted;
    if (inserted * kTetsPerVertex <= mesh.tet_count()) break;
  }
  return all;
}

std::int64_t contract_loose(LocalOperations& work, std::span<const char> loose, double bad,
                            const RunContext& context) {
  const TetComplex& mesh = work.mesh();
  std::int64_t contracted = 0;
  std::vector<Index> tets;
  std::vector<std::pair<double, Index>> ends;
  for (Index v = 0; v < static_cast<Index>(loose.size()); ++v) {
    if (!loose[v] || work.fixed(v)) continue;
    if (context.stop()) return contracted;
    mesh.star(v, tets);
    if (std::none_of(tets.begin(), tets.end(), [&](Index t) { return work.quality(t) < bad; })) continue;
    ends.clear();
    for (const Index t : tets)
      for (const Index w : mesh.tet(t))
        if (w != v) ends.emplace_back((mesh.position(w) - mesh.position(v)).squaredNorm(), w);
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    for (const auto& [length, w] : ends)
      if (work.collapse(v, w, bad)) {
        ++contracted;
        break;
      }
  }
  return contracted;
}

}  // namespace overtet

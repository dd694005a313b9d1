#include "src/improve/trade.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "src/improve/bad_tets.h"
#include "src/improve/tuning.h"

namespace overtet {

std::int64_t fewer_bad(LocalOperations& work, const LocalOperations::Price& price, NewVertices may,
                       const RunContext& context) {
  const TetComplex& mesh = work.mesh();
  const bool insert = may == NewVertices::some;
  work.be_thorough();
  // A tet that resisted is left alone until something at its corners changes, and so is a vertex that stayed.
  std::int64_t now = 1, all = 0;
  std::vector<std::int64_t> touched(mesh.vertex_count(), 0), rested(mesh.vertex_count(), -1),
      tried(mesh.tet_capacity(), -1);
  const auto touch = [&] {
    ++now;
    touched.resize(mesh.vertex_count(), 0);
    rested.resize(mesh.vertex_count(), -1);
    tried.resize(mesh.tet_capacity(), -1);
    for (const Index t : work.changed())
      for (const Index v : mesh.tet(t)) touched[v] = now;
    return true;
  };
  for (int pass = 0; pass < kMostRounds; ++pass) {
    const std::vector<BadTet> bad = bad_tets(mesh, [&](Index t) -> std::optional<double> {
      return price(work.quality(t)) > 0 ? std::optional(-work.quality(t)) : std::nullopt;
    });
    // New vertices only where the old ones have found their places.
    const bool may_insert = insert && pass > 0;
    std::int64_t changes = 0;
    for (const BadTet& b : bad) {
      if (context.stop()) return all + changes;
      if (!b.still_in(mesh) || !(price(work.quality(b.tet)) > 0)) continue;
      const auto& c = b.corners;
      const std::int64_t last = std::max({touched[c[0]], touched[c[1]], touched[c[2]], touched[c[3]]});
      if (tried[b.tet] >= last) continue;
      bool done = false;
      for (const Index v : c) {
        if (done || rested[v] >= touched[v]) continue;
        if (work.smooth_cheaper(v, price))
          done = touch();
        else
          rested[v] = now;
      }
      for (const auto& [i, j] : kTetEdge)
        if (!done && (work.collapse_cheaper(c[i], c[j], price) || work.collapse_cheaper(c[j], c[i], price)))
          done = touch();
      if (!done && may_insert && work.insert_cheaper(b.tet, price)) done = touch();
      if (done) ++changes;
      // The first pass has not tried all means.
      if (!done && (may_insert || !insert)) tried[b.tet] = now;
    }
    all += changes;
    if (changes * kTetsPerChange <= static_cast<std::int64_t>(bad.size()) && (pass > 0 || !insert)) break;
  }
  return all;
}

}  // namespace overtet

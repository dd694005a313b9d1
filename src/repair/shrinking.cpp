#include "src/repair/shrinking.h"

#include <algorithm>

namespace overtet {

Result<Index> shrink(Clusters& clusters, const Surface& input, const VertexMatrix& base,
                     const VertexRings& rings, double diagonal, const RepairOptions& options,
                     const RunContext& context) {
  std::vector<Cluster>& all = clusters.all();
  Index rounds = 0;
  std::vector<Offence> offences;
  // Counted, not timed: the same result on every machine.
  double work = 0;
  const auto work_left = [&] { return rounds < options.max_shrink_rounds && work < options.shrink_work; };
  // Judges what compose() makes; returns the clusters that must go back.
  const auto judge = [&](std::vector<char>& bad) -> Status {
    ++rounds;
    Result<Findings> found =
        find_offences({clusters.compose(base), input.F}, rings, diagonal, false, context);
    if (!found) return found.error();
    offences = std::move(found.value().offences);
    work += static_cast<double>(found.value().diagnosis.pairs.size()) +
            0.01 * static_cast<double>(input.F.rows());
    bad.assign(all.size(), 0);
    for (const Offence& o : offences) {
      bool known = false;
      for (std::size_t c = 0; c < all.size(); ++c)
        if (clusters.within(all[c], o, 1)) bad[c] = 1, known = true;
      if (!known) bad.assign(all.size(), 1);
    }
    return success();
  };
  std::vector<Cluster> good = all;
  std::vector<char> bad;
  std::vector<double> low(all.size(), 0), high(all.size(), 1);
  for (std::size_t c = 0; c < all.size(); ++c)
    if (clusters.pinned(all[c])) low[c] = 1;  // being feasible is not enough there
  for (int i = 0; i < 4 && work_left(); ++i) {
    for (std::size_t c = 0; c < all.size(); ++c) all[c].part = (low[c] + high[c]) / 2;
    if (Status s = judge(bad); !s) return s.error();
    const bool clean = offences.empty();
    for (std::size_t c = 0; c < all.size(); ++c) (bad[c] ? low : high)[c] = all[c].part;
    if (clean) good = all;
    // Together they must still be fine: kept only when a later judgement of `high` says so.
    for (std::size_t c = 0; c < all.size(); ++c) all[c].part = high[c];
    if (!clean) {
      if (Status s = judge(bad); !s) return s.error();
      if (offences.empty()) good = all;
    }
  }
  all = good;
  // Vertices: batches of each cluster that halve when refused, smallest moves first.
  struct Trial {
    std::vector<Index> order;
    std::size_t at = 0, size = 1;
  };
  std::vector<Trial> trials(all.size());
  for (std::size_t c = 0; c < all.size(); ++c) {
    const Cluster& x = all[c];
    if (clusters.pinned(x)) continue;
    std::vector<std::pair<double, Index>> order;
    for (std::size_t i = 0; i < x.region.size(); ++i)
      order.emplace_back((x.to.row(static_cast<Eigen::Index>(i)) - base.row(x.region[i])).norm(),
                         x.region[i]);
    std::sort(order.begin(), order.end());
    for (const auto& [length, v] : order) trials[c].order.push_back(v);
    trials[c].size = std::max<std::size_t>(1, order.size() / 2);
  }
  while (work_left()) {
    bool any = false;
    for (std::size_t c = 0; c < all.size(); ++c) {
      Trial& t = trials[c];
      const std::size_t last = std::min(t.at + t.size, t.order.size());
      std::vector<Index>& held = all[c].held;
      for (std::size_t i = t.at; i < last; ++i) held.push_back(t.order[i]), any = true;
      std::sort(held.begin(), held.end());
    }
    if (!any) break;
    if (Status s = judge(bad); !s) return s.error();
    const bool clean = offences.empty();
    for (std::size_t c = 0; c < all.size(); ++c) {
      Trial& t = trials[c];
      if (!bad[c]) {
        t.at = std::min(t.at + t.size, t.order.size());
        continue;
      }
      all[c].held = good[c].held;
      if (t.size > 1)
        t.size = (t.size + 1) / 2;
      else
        t.at = std::min(t.at + 1, t.order.size());
    }
    if (!clean) {
      if (Status s = judge(bad); !s) return s.error();
      if (!offences.empty()) {
        all = good;  // accepted one by one, refused together
        for (Trial& t : trials) t.size = std::max<std::size_t>(1, t.size / 2), t.at = 0;
        continue;
      }
    }
    good = all;
  }
  all = good;
  return rounds;
}

}  // namespace overtet

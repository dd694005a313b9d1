#include "src/repair/shrinking.h"

#include <algorithm>

#include "kernels/core/assertions.h"

namespace overtet {

namespace {

// Moves less, as long as nothing objects. Kept is what was last judged to be fine as a whole.
class Shrinking {
 public:
  Shrinking(Clusters& clusters, const Surface& input, const VertexMatrix& base, const VertexRings& rings,
            double diagonal, const RepairOptions& options, const RunContext& context)
      : clusters_(clusters),
        all_(clusters.all()),
        input_(input),
        base_(base),
        rings_(rings),
        diagonal_(diagonal),
        options_(options),
        context_(context) {}

  Result<Index> run() {
    OVERTET_EXPECTS_COSTLY([&] {
      const auto found =
          find_offences({clusters_.compose(base_), input_.F}, rings_, diagonal_, PokingOut::pairs, context_);
      return !found || found.value().offences.empty();
    }());
    good_ = all_;
    if (Status s = bisect(); !s) return s.error();
    all_ = good_;
    if (Status s = hold_vertices(); !s) return s.error();
    all_ = good_;
    return rounds_;
  }

 private:
  // Counted, not timed: the same result on every machine.
  bool work_left() const { return rounds_ < options_.max_shrink_rounds && work_ < options_.shrink_work; }

  // Looks at what compose() makes; bad_: the clusters that must go back. True: nothing objects.
  Result<bool> judge() {
    ++rounds_;
    Result<Findings> found =
        find_offences({clusters_.compose(base_), input_.F}, rings_, diagonal_, PokingOut::pairs, context_);
    if (!found) return found.error();
    const std::vector<Offence>& offences = found.value().offences;
    work_ += static_cast<double>(found.value().diagnosis.pairs.size()) +
             0.01 * static_cast<double>(input_.F.rows());
    bad_.assign(all_.size(), 0);
    for (const Offence& o : offences) {
      bool known = false;
      for (std::size_t c = 0; c < all_.size(); ++c)
        if (clusters_.within(all_[c], o, 1)) bad_[c] = 1, known = true;
      if (!known) bad_.assign(all_.size(), 1);
    }
    return offences.empty();
  }

  // How much of its way each cluster must go, but for those that are pinned: being feasible is not enough
  // there.
  Status bisect() {
    std::vector<double> low(all_.size(), 0), high(all_.size(), 1);
    for (std::size_t c = 0; c < all_.size(); ++c)
      if (clusters_.pinned(all_[c])) low[c] = 1;
    for (int i = 0; i < 4 && work_left(); ++i) {
      for (std::size_t c = 0; c < all_.size(); ++c) all_[c].part = (low[c] + high[c]) / 2;
      const Result<bool> clean = judge();
      if (!clean) return clean.error();
      for (std::size_t c = 0; c < all_.size(); ++c) (bad_[c] ? low : high)[c] = all_[c].part;
      if (clean.value()) good_ = all_;
      // Together they must still be fine: kept only when a later judgement of `high` says so.
      for (std::size_t c = 0; c < all_.size(); ++c) all_[c].part = high[c];
      if (clean.value()) continue;
      const Result<bool> together = judge();
      if (!together) return together.error();
      if (together.value()) good_ = all_;
    }
    return success();
  }

  // A batch of a cluster's vertices that stay where they were, the smallest moves first.
  struct Trial {
    std::vector<Index> order;
    std::size_t at = 0, size = 1;
  };

  Trial trial_of(const Cluster& cluster) const {
    Trial trial;
    if (clusters_.pinned(cluster)) return trial;
    std::vector<std::pair<double, Index>> order;
    for (std::size_t i = 0; i < cluster.region.size(); ++i)
      order.emplace_back((cluster.to.row(static_cast<Eigen::Index>(i)) - base_.row(cluster.region[i])).norm(),
                         cluster.region[i]);
    std::sort(order.begin(), order.end());
    for (const auto& [length, v] : order) trial.order.push_back(v);
    trial.size = std::max<std::size_t>(1, order.size() / 2);
    return trial;
  }

  // Vertex by vertex, in batches of each cluster that halve when refused.
  Status hold_vertices() {
    std::vector<Trial> trials;
    for (const Cluster& cluster : all_) trials.push_back(trial_of(cluster));
    while (work_left()) {
      bool any = false;
      for (std::size_t c = 0; c < all_.size(); ++c) {
        Trial& t = trials[c];
        const std::size_t last = std::min(t.at + t.size, t.order.size());
        std::vector<Index>& held = all_[c].held;
        for (std::size_t i = t.at; i < last; ++i) held.push_back(t.order[i]), any = true;
        std::sort(held.begin(), held.end());
      }
      if (!any) break;
      const Result<bool> clean = judge();
      if (!clean) return clean.error();
      for (std::size_t c = 0; c < all_.size(); ++c) settle(c, trials[c]);
      if (!clean.value()) {
        const Result<bool> together = judge();
        if (!together) return together.error();
        if (!together.value()) {
          all_ = good_;  // accepted one by one, refused together
          for (Trial& t : trials) t.size = std::max<std::size_t>(1, t.size / 2), t.at = 0;
          continue;
        }
      }
      good_ = all_;
    }
    return success();
  }

  // After a judgement: the next batch, or a smaller one.
  void settle(std::size_t c, Trial& t) {
    if (!bad_[c]) {
      t.at = std::min(t.at + t.size, t.order.size());
      return;
    }
    all_[c].held = good_[c].held;
    if (t.size > 1)
      t.size = (t.size + 1) / 2;
    else
      t.at = std::min(t.at + 1, t.order.size());
  }

  Clusters& clusters_;
  std::vector<Cluster>& all_;
  const Surface& input_;
  const VertexMatrix& base_;
  const VertexRings& rings_;
  const double diagonal_;
  const RepairOptions& options_;
  const RunContext& context_;
  std::vector<Cluster> good_;
  std::vector<char> bad_;
  Index rounds_ = 0;
  double work_ = 0;
};

}  // namespace

Result<Index> shrink(Clusters& clusters, const Surface& input, const VertexMatrix& base,
                     const VertexRings& rings, double diagonal, const RepairOptions& options,
                     const RunContext& context) {
  return Shrinking(clusters, input, base, rings, diagonal, options, context).run();
}

}  // namespace overtet

#include "src/improve/passes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "src/improve/bad_tets.h"
#include "src/improve/tuning.h"

namespace overtet {

namespace {

// Means beyond flips, for tets that resisted them.
enum class Means { cheap, strong };  // strong: collapses and insertions as well

// The passes over one complex. Its many members are what one pass tells the next one.
class Passes {
 public:
  Passes(LocalOperations& work, std::span<const char> fresh, const ImproveOptions& options, Care care,
         double seconds, const RunContext& context)
      : work_(work),
        mesh_(work.mesh()),
        options_(options),
        context_(context),
        smoothing_gain_(care == Care::by_all_means ? kAnyGain : kPays),
        insertion_gain_(care == Care::by_all_means ? kAnyGain : kInsertionPays),
        target_(std::sin(options.target_degrees * M_PI / 180)),
        insert_below_(std::sin(std::min(options.insert_below_degrees, options.target_degrees) * M_PI / 180)),
        most_tets_(static_cast<std::int64_t>(options.growth * static_cast<double>(mesh_.tet_count())) + 100),
        effort_left_(static_cast<std::int64_t>(options.effort * static_cast<double>(mesh_.tet_count())) +
                     1000),
        begin_(RunContext::Clock::now()),
        seconds_(seconds),
        means_(care == Care::by_all_means ? Means::strong : Means::cheap),
        touched_(mesh_.vertex_count(), 0),
        attempts_(mesh_.tet_capacity()) {
    work_.be_thorough(care == Care::by_all_means);
    if (!fresh.empty())
      for (Index t = 0; t < mesh_.tet_capacity(); ++t)
        if (mesh_.alive(t) && std::none_of(mesh_.tet(t).begin(), mesh_.tet(t).end(),
                                           [&](Index v) { return v < Index(fresh.size()) && fresh[v]; }))
          attempts_[t] = {0, Means::strong};
  }

  PassesResult run() {
    result_.end = ImproveResult::End::passes_done;
    int extra = 0;
    for (int pass = 0; pass < options_.passes + extra; ++pass) {
      const std::vector<BadTet> bad = bad_tets(mesh_, [&](Index t) { return rank(t); });
      if (bad.empty()) {
        result_.end = ImproveResult::End::target_reached;
        break;
      }
      if (bad.front().rank < kThin && extra < kMostRounds) ++extra;
      context_.report("improve", double(pass) / (options_.passes + extra),
                      std::to_string(bad.size()) + " tets below " +
                          std::to_string(int(options_.target_degrees)) + " degrees");
      const Means means = means_;
      const bool whole = work_through(bad);
      if (!whole || !worth_another(result_.passes.back(), means)) break;
    }
    return std::move(result_);
  }

 private:
  struct Attempt {
    std::int64_t time = -1;
    Means means = Means::cheap;
  };

  static double since(RunContext::Clock::time_point t) {
    return std::chrono::duration<double>(RunContext::Clock::now() - t).count();
  }

  bool touch() {
    ++now_;
    touched_.resize(mesh_.vertex_count(), 0);
    for (const Index t : work_.changed())
      for (const Index v : mesh_.tet(t)) touched_[v] = now_;
    return true;
  }

  std::int64_t last_touched(const TetComplex::Tet& c) const {
    return std::max({touched_[c[0]], touched_[c[1]], touched_[c[2]], touched_[c[3]]});
  }

  std::optional<double> rank(Index t) const {
    if (!(work_.quality(t) < target_)) return std::nullopt;
    const bool resisted_before = t < Index(attempts_.size()) && attempts_[t].time == 0;
    if (resisted_before && last_touched(mesh_.tet(t)) == 0) return std::nullopt;
    return work_.quality(t);
  }

  // What touches a cut is worked on with more around it in the next round; here it gets the cheap means only.
  bool at_cut(const TetComplex::Tet& c) const {
    return std::any_of(c.begin(), c.end(), [&](Index v) { return work_.shared(v); });
  }

  bool still(const BadTet& b) const { return b.still_in(mesh_) && work_.quality(b.tet) < target_; }

  // One pass. False: time or effort has come to an end.
  bool work_through(const std::vector<BadTet>& bad) {
    const auto pass_begin = RunContext::Clock::now();
    ImprovePass record;
    record.bad = static_cast<std::int64_t>(bad.size());
    record.worst_sine = bad.front().rank;
    bool whole = true;
    for (const BadTet& b : bad) {
      if (since(begin_) > seconds_ || context_.stop()) {
        result_.end = ImproveResult::End::time_over;
        whole = false;
        break;
      }
      if (!still(b)) continue;
      if (b.tet < static_cast<Index>(attempts_.size())) {
        const Attempt& last = attempts_[b.tet];
        if (last.means >= means_ && last.time >= last_touched(b.corners)) continue;
      }
      if (--effort_left_ < 0) {
        result_.end = ImproveResult::End::effort_spent;
        whole = false;
        break;
      }
      mend(b, record);
    }
    record.seconds = since(pass_begin);
    result_.passes.push_back(record);
    return whole;
  }

  void mend(const BadTet& b, ImprovePass& record) {
    const auto c = b.corners;
    if (flip(b, record) || at_cut(c)) return;
    for (const Index v : c) {
      if (!still(b)) break;
      if (v < static_cast<Index>(rested_.size()) && rested_[v] >= touched_[v]) continue;
      if (work_.smooth(v, smoothing_gain_)) {
        ++record.smoothed;
        touch();
      } else {
        rested_.resize(touched_.size(), -1);
        rested_[v] = now_;
      }
    }
    if (still(b) && (means_ == Means::strong || b.rank < kThin) && collapse_or_insert(b, record)) return;
    if (still(b)) {
      attempts_.resize(mesh_.tet_capacity());
      attempts_[b.tet] = {now_, means_};
    }
  }

  bool flip(const BadTet& b, ImprovePass& record) {
    const auto c = b.corners;
    for (const auto& [i, j] : kTetEdge)
      if (work_.remove_edge(b.tet, c[i], c[j])) {
        ++record.removed_edges;
        return touch();
      }
    for (int k = 0; k < 4; ++k)
      if (work_.flip_23(b.tet, k)) {
        ++record.flips;
        return touch();
      }
    return false;
  }

  bool collapse_or_insert(const BadTet& b, ImprovePass& record) {
    const auto c = b.corners;
    for (const auto& [i, j] : kTetEdge)
      if (work_.collapse(c[i], c[j]) || work_.collapse(c[j], c[i])) {
        ++record.collapsed;
        return touch();
      }
    if (means_ == Means::strong && options_.insert_vertices && work_.quality(b.tet) < insert_below_ &&
        mesh_.tet_count() < most_tets_ && work_.insert_around(b.tet, insertion_gain_)) {
      ++record.inserted;
      return touch();
    }
    return false;
  }

  // Whether there is to be another pass after this one, with these means; chooses the next one's.
  bool worth_another(const ImprovePass& record, Means means) {
    const std::int64_t changes =
        record.removed_edges + record.flips + record.smoothed + record.collapsed + record.inserted;
    const bool slow = bad_before_ >= 0 && double(record.bad) > kSlow * double(bad_before_);
    bad_before_ = record.bad;
    const bool was_strong = means == Means::strong;
    if (was_strong && changes == 0) {
      result_.end = ImproveResult::End::no_progress;
      return false;
    }
    if (slow || changes == 0) means_ = Means::strong;
    // What is left are tets that the boundary itself makes thin; the worst of all are over with.
    const bool worst_grows = record.worst_sine < kThin && record.worst_sine > 1.5 * worst_before_;
    worst_before_ = record.worst_sine;
    const bool idle =
        was_strong && slow && !worst_grows && record.inserted + record.collapsed < record.bad / kIdlePart;
    idle_ = idle ? idle_ + 1 : 0;
    if (idle_ < kInVain) return true;
    result_.end = ImproveResult::End::no_progress;
    return false;
  }

  LocalOperations& work_;
  const TetComplex& mesh_;
  const ImproveOptions& options_;
  const RunContext& context_;
  const double smoothing_gain_, insertion_gain_;  // factors
  const double target_, insert_below_;            // smallest dihedral sines
  const std::int64_t most_tets_;
  std::int64_t effort_left_;  // tets
  const RunContext::Clock::time_point begin_;
  const double seconds_;
  Means means_;
  // A tet that resisted is left alone until something at its corners changes or stronger means come.
  std::int64_t now_ = 1;
  std::vector<std::int64_t> touched_;  // when something changed at a vertex
  std::vector<std::int64_t> rested_;   // when a vertex was last found where it is best
  std::vector<Attempt> attempts_;
  std::int64_t bad_before_ = -1;
  double worst_before_ = 0;
  int idle_ = 0;
  PassesResult result_;
};

}  // namespace

PassesResult improve_passes(LocalOperations& work, std::span<const char> fresh, const ImproveOptions& options,
                            Care care, double seconds, const RunContext& context) {
  return Passes(work, fresh, options, care, seconds, context).run();
}

}  // namespace overtet

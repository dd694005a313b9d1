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

// The passes over one complex.
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
        budget_{static_cast<std::int64_t>(options.growth * static_cast<double>(mesh_.tet_count())) + 100,
                static_cast<std::int64_t>(options.effort * static_cast<double>(mesh_.tet_count())) + 1000,
                RunContext::Clock::now(), seconds} {
    if (care == Care::by_all_means) work_.be_thorough();
    if (care == Care::by_all_means) course_.means = Means::strong;
    history_.touched.assign(mesh_.vertex_count(), 0);
    history_.attempts.resize(mesh_.tet_capacity());
    if (!fresh.empty())
      for (Index t = 0; t < mesh_.tet_capacity(); ++t)
        if (mesh_.alive(t) && std::none_of(mesh_.tet(t).begin(), mesh_.tet(t).end(),
                                           [&](Index v) { return v < Index(fresh.size()) && fresh[v]; }))
          history_.attempts[t] = {0, Means::strong};
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
      const Means means = course_.means;
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
    ++history_.now;
    history_.touched.resize(mesh_.vertex_count(), 0);
    for (const Index t : work_.changed())
      for (const Index v : mesh_.tet(t)) history_.touched[v] = history_.now;
    return true;
  }

  std::int64_t last_touched(const TetComplex::Tet& c) const {
    return std::max(
        {history_.touched[c[0]], history_.touched[c[1]], history_.touched[c[2]], history_.touched[c[3]]});
  }

  std::optional<double> rank(Index t) const {
    if (!(work_.quality(t) < target_)) return std::nullopt;
    const bool resisted_before = t < Index(history_.attempts.size()) && history_.attempts[t].time == 0;
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
      if (since(budget_.begin) > budget_.seconds || context_.stop()) {
        result_.end = ImproveResult::End::time_over;
        whole = false;
        break;
      }
      if (!still(b)) continue;
      if (b.tet < static_cast<Index>(history_.attempts.size())) {
        const Attempt& last = history_.attempts[b.tet];
        if (last.means >= course_.means && last.time >= last_touched(b.corners)) continue;
      }
      if (--budget_.effort_left < 0) {
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
      if (v < static_cast<Index>(history_.rested.size()) && history_.rested[v] >= history_.touched[v])
        continue;
      if (work_.smooth(v, smoothing_gain_)) {
        ++record.smoothed;
        touch();
      } else {
        history_.rested.resize(history_.touched.size(), -1);
        history_.rested[v] = history_.now;
      }
    }
    if (still(b) && (course_.means == Means::strong || b.rank < kThin) && collapse_or_insert(b, record))
      return;
    if (still(b)) {
      history_.attempts.resize(mesh_.tet_capacity());
      history_.attempts[b.tet] = {history_.now, course_.means};
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
    if (course_.means == Means::strong && options_.insert_vertices && work_.quality(b.tet) < insert_below_ &&
        mesh_.tet_count() < budget_.most_tets && work_.insert_around(b.tet, insertion_gain_)) {
      ++record.inserted;
      return touch();
    }
    return false;
  }

  // Whether there is to be another pass after this one, with these means; chooses the next one's.
  bool worth_another(const ImprovePass& record, Means means) {
    const std::int64_t changes =
        record.removed_edges + record.flips + record.smoothed + record.collapsed + record.inserted;
    const bool slow = course_.bad_before >= 0 && double(record.bad) > kSlow * double(course_.bad_before);
    course_.bad_before = record.bad;
    const bool was_strong = means == Means::strong;
    if (was_strong && changes == 0) {
      result_.end = ImproveResult::End::no_progress;
      return false;
    }
    if (slow || changes == 0) course_.means = Means::strong;
    // What is left are tets that the boundary itself makes thin; the worst of all are over with.
    const bool worst_grows = record.worst_sine < kThin && record.worst_sine > 1.5 * course_.worst_before;
    course_.worst_before = record.worst_sine;
    const bool idle =
        was_strong && slow && !worst_grows && record.inserted + record.collapsed < record.bad / kIdlePart;
    course_.idle = idle ? course_.idle + 1 : 0;
    if (course_.idle < kInVain) return true;
    result_.end = ImproveResult::End::no_progress;
    return false;
  }

  struct Budget {
    std::int64_t most_tets;
    std::int64_t effort_left;  // tets
    RunContext::Clock::time_point begin;
    double seconds;
  };
  // A tet that resisted is left alone until something at its corners changes or stronger means come.
  struct History {
    std::int64_t now = 1;
    std::vector<std::int64_t> touched;  // when something changed at a vertex
    std::vector<std::int64_t> rested;   // when a vertex was last found where it is best
    std::vector<Attempt> attempts;      // at tets
  };
  // From pass to pass.
  struct Course {
    Means means = Means::cheap;
    std::int64_t bad_before = -1;
    double worst_before = 0;
    int idle = 0;
  };

  LocalOperations& work_;
  const TetComplex& mesh_;
  const ImproveOptions& options_;
  const RunContext& context_;
  const double smoothing_gain_, insertion_gain_;  // factors
  const double target_, insert_below_;            // smallest dihedral sines
  Budget budget_;
  History history_;
  Course course_;
  PassesResult result_;
};

}  // namespace

PassesResult improve_passes(LocalOperations& work, std::span<const char> fresh, const ImproveOptions& options,
                            Care care, double seconds, const RunContext& context) {
  return Passes(work, fresh, options, care, seconds, context).run();
}

}  // namespace overtet

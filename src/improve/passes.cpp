#include "src/improve/passes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "src/improve/bad_tets.h"

namespace overtet {

namespace {

// How many tets are worked on between two looks at the clock.
constexpr int kPollEvery = 64;
// A pass that leaves more than this part of the bad tets calls for stronger means.
constexpr double kSlow = 0.9;
// Sines below this are hopeless for a while: thin layers grow by a factor per pass, they get more passes.
constexpr double kThin = 1e-2;
constexpr int kExtraPassesForThin = 40;
// This many passes in a row that leave nearly all bad tets, with few collapses and insertions, are enough.
constexpr int kIdlePasses = 3;
constexpr std::int64_t kIdlePart = 10;
// Smoothing that gains less, and insertions that gain less, cost more time and tets than they are worth.
struct Gains {
  double smooth, insert;
};
constexpr Gains kPays{1.05, 1.2}, kAny{1.001, 1.001};

}  // namespace

PassesResult improve_passes(LocalOperations& work, std::span<const char> fresh, const ImproveOptions& options,
                            bool by_all_means, double seconds, const RunContext& context) {
  const Gains gains = by_all_means ? kAny : kPays;
  work.be_thorough(by_all_means);
  const auto begin = RunContext::Clock::now();
  const auto since = [](RunContext::Clock::time_point t) {
    return std::chrono::duration<double>(RunContext::Clock::now() - t).count();
  };
  const TetComplex& mesh = work.mesh();
  const double target = std::sin(options.target_degrees * M_PI / 180);
  PassesResult result;
  const double insert_below =
      std::sin(std::min(options.insert_below_degrees, options.target_degrees) * M_PI / 180);
  const auto most_tets =
      static_cast<std::int64_t>(options.growth * static_cast<double>(mesh.tet_count())) + 100;
  auto effort_left = static_cast<std::int64_t>(options.effort * static_cast<double>(mesh.tet_count())) + 1000;

  // A tet that resisted is left alone until something at its corners changes or stronger means come.
  std::int64_t now = 1;
  std::vector<std::int64_t> touched(mesh.vertex_count(), 0);
  std::vector<std::int64_t> rested;  // when a vertex was last found where it is best
  struct Attempt {
    std::int64_t time = -1;
    bool strong = false;
  };
  std::vector<Attempt> attempts(mesh.tet_capacity());
  const auto touch = [&] {
    ++now;
    touched.resize(mesh.vertex_count(), 0);
    for (const Index t : work.changed())
      for (const Index v : mesh.tet(t)) touched[v] = now;
    return true;
  };

  if (!fresh.empty())
    for (Index t = 0; t < mesh.tet_capacity(); ++t)
      if (mesh.alive(t) && std::none_of(mesh.tet(t).begin(), mesh.tet(t).end(),
                                        [&](Index v) { return v < Index(fresh.size()) && fresh[v]; }))
        attempts[t] = {0, true};
  const auto last_touched = [&](const TetComplex::Tet& c) {
    return std::max({touched[c[0]], touched[c[1]], touched[c[2]], touched[c[3]]});
  };

  const auto rank = [&](Index t) -> std::optional<double> {
    if (!(work.quality(t) < target)) return std::nullopt;
    const bool resisted_before = t < Index(attempts.size()) && attempts[t].time == 0;
    if (resisted_before && last_touched(mesh.tet(t)) == 0) return std::nullopt;
    return work.quality(t);
  };
  // What touches a cut is worked on with more around it in the next round; here it gets the cheap means only.
  const auto at_cut = [&](const TetComplex::Tet& c) {
    return std::any_of(c.begin(), c.end(), [&](Index v) { return work.shared(v); });
  };
  const auto still = [&](const BadTet& b) { return b.still_in(mesh) && work.quality(b.tet) < target; };

  static constexpr int kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  bool strong = by_all_means;  // collapses and insertions as well
  std::int64_t weight_before = -1;
  int extra = 0, idle = 0;
  double worst_before = 0;
  result.end = ImproveResult::End::passes_done;
  for (int pass = 0; pass < options.passes + extra; ++pass) {
    const auto pass_begin = RunContext::Clock::now();
    const std::vector<BadTet> bad = bad_tets(mesh, rank);
    ImprovePass record;
    record.bad = static_cast<std::int64_t>(bad.size());
    if (bad.empty()) {
      result.end = ImproveResult::End::target_reached;
      break;
    }
    record.worst_sine = bad.front().rank;
    if (bad.front().rank < kThin && extra < kExtraPassesForThin) ++extra;
    context.report("improve", double(pass) / (options.passes + extra),
                   std::to_string(bad.size()) + " tets below " + std::to_string(int(options.target_degrees)) +
                       " degrees");

    const bool was_strong = strong;
    int count = 0;
    for (const BadTet& b : bad) {
      if (++count % kPollEvery == 0) {
        if (since(begin) > seconds || context.stop()) {
          result.end = ImproveResult::End::time_over;
          break;
        }
      }
      if (!still(b)) continue;
      const auto c = b.corners;
      if (b.tet < static_cast<Index>(attempts.size())) {
        const Attempt& last = attempts[b.tet];
        if ((last.strong || !strong) && last.time >= last_touched(c)) continue;
      }
      if (--effort_left < 0) {
        result.end = ImproveResult::End::effort_spent;
        break;
      }
      bool done = false;
      for (const auto& e : kEdges) {
        if (done) break;
        if (work.remove_edge(b.tet, c[e[0]], c[e[1]])) {
          ++record.removed_edges;
          done = touch();
        }
      }
      for (int k = 0; k < 4 && !done; ++k)
        if (work.flip_23(b.tet, k)) {
          ++record.flips;
          done = touch();
        }
      if (done || at_cut(c)) continue;
      for (const Index v : c) {
        if (!still(b)) break;
        if (v < static_cast<Index>(rested.size()) && rested[v] >= touched[v]) continue;
        if (work.smooth(v, gains.smooth)) {
          ++record.smoothed;
          touch();
        } else {
          rested.resize(touched.size(), -1);
          rested[v] = now;
        }
      }
      if (still(b) && (strong || b.rank < kThin)) {
        for (const auto& e : kEdges) {
          if (done) break;
          if (work.collapse(c[e[0]], c[e[1]]) || work.collapse(c[e[1]], c[e[0]])) {
            ++record.collapsed;
            done = touch();
          }
        }
        if (!done && strong && options.insert_vertices && work.quality(b.tet) < insert_below &&
            mesh.tet_count() < most_tets) {
          if (work.insert_around(b.tet, gains.insert)) {
            ++record.inserted;
            done = touch();
          }
        }
      }
      if (!done && still(b)) {
        attempts.resize(mesh.tet_capacity());
        attempts[b.tet] = {now, strong};
      }
    }
    record.seconds = since(pass_begin);
    result.passes.push_back(record);
    if (result.end == ImproveResult::End::time_over || result.end == ImproveResult::End::effort_spent) break;
    const std::int64_t changes =
        record.removed_edges + record.flips + record.smoothed + record.collapsed + record.inserted;
    const bool slow = weight_before >= 0 && double(record.bad) > kSlow * double(weight_before);
    weight_before = record.bad;
    if (was_strong && changes == 0) {
      result.end = ImproveResult::End::no_progress;
      break;
    }
    if (slow || changes == 0) strong = true;
    // What is left are tets that the boundary itself makes thin; the worst of all are over with.
    const bool worst_grows = record.worst_sine < kThin && record.worst_sine > 1.5 * worst_before;
    worst_before = record.worst_sine;
    idle = was_strong && slow && !worst_grows && record.inserted + record.collapsed < record.bad / kIdlePart
               ? idle + 1
               : 0;
    if (idle >= kIdlePasses) {
      result.end = ImproveResult::End::no_progress;
      break;
    }
  }
  return result;
}

}  // namespace overtet

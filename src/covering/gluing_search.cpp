#include "src/covering/gluing_search.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace overtet {

namespace {

// Gluings of single regions looked at in the first attempt; each one after it, which knows where the last
// ones failed, may look at half as many more.
constexpr std::int64_t kFirstSteps = 10'000;

int ending(const Way& way) {
  int sum = 0;
  for (const int c : way) sum += c;
  const int n = static_cast<int>(way.size());
  return n * (n + 1) / 2 - sum;
}

}  // namespace

bool holds(const GluingCondition& c, const std::vector<const Way*>& ways) {
  const auto inverse = [](const Way& way, int x) {
    return static_cast<int>(std::find(way.begin(), way.end(), x) - way.begin());
  };
  const auto across = [&](int sector, int x, bool back = false) {
    if (c.names[sector] < 0) return x;
    const Way& way = *ways[c.names[sector]];
    return back != (c.backwards[sector] != 0) ? inverse(way, x) : static_cast<int>(way[x]);
  };
  if (c.most < 0) {
    const Way &fp = *ways[c.regions[0]], &gp = *ways[c.regions[1]], &fm = *ways[c.regions[2]],
              &gm = *ways[c.regions[3]];
    for (int k = 0; k < static_cast<int>(fp.size()); ++k)
      if (across(3, fm[across(2, gp[across(0, k)], true)]) != gm[across(1, fp[k])]) return false;
    return gm[across(1, ending(fp))] == across(3, ending(fm)) &&
           across(3, fm[across(2, ending(gp), true)]) == ending(gm);
  }
  // The second part in the names of the first.
  const Way &l = *ways[c.regions[0]], &other = *ways[c.regions[1]];
  Way r(l.size());
  for (int k = 0; k < static_cast<int>(l.size()); ++k)
    r[k] = static_cast<signed char>(across(1, other[across(0, k)], true));
  unsigned passed = 0;
  int at = ending(l), turns = 0;
  const int end = ending(r);
  while (at != end) {
    const int back = inverse(r, at);
    passed |= 1u << back;
    at = l[back];
    if (++turns > c.most) return false;
  }
  for (std::size_t k = 0; k < l.size(); ++k)
    if (!(passed >> k & 1) && l[k] != r[k]) return false;
  return true;
}

GluingSearch::GluingSearch(std::vector<GluingCondition> conditions, const std::vector<Index>& outer,
                           const std::vector<Index>& inner, const std::vector<int>& sheets,
                           const RunContext& context)
    : conditions_(std::move(conditions)), outer_(outer), inner_(inner), sheets_(sheets), context_(context) {
  const std::size_t n = outer.size();
  of_.resize(n);
  ways_.resize(n);
  way_.assign(n, nullptr);
  for (const GluingCondition& c : conditions_) weight_.push_back(c.weight);
  used_.assign(conditions_.size(), 0);
  for (std::size_t k = 0; k < conditions_.size(); ++k)
    conditions_[k].each([&](Index r) {
      if (of_[r].empty()) regions_.push_back(r);
      if (of_[r].empty() || of_[r].back() != static_cast<Index>(k)) of_[r].push_back(static_cast<Index>(k));
    });
  std::sort(regions_.begin(), regions_.end());
  list_ways();
}

std::vector<GluingCondition> GluingSearch::needed() const {
  std::vector<GluingCondition> out;
  for (std::size_t k = 0; k < used_.size(); ++k)
    if (used_[k]) out.push_back(conditions_[k]), out.back().weight = weight_[k];
  return out;
}

GluingSearch::Answer GluingSearch::run(std::int64_t most) {
  for (std::size_t k = 0; k < conditions_.size(); ++k)
    if (is_known(conditions_[k]) && !holds(conditions_[k], way_)) {
      used_[k] = 1;
      return Answer::none;
    }
  // Independent parts one after the other.
  std::vector<char> seen(of_.size(), 0);
  for (const Index seed : regions_) {
    if (way_[seed] || seen[seed]) continue;
    std::vector<Index> part{seed};
    seen[seed] = 1;
    for (std::size_t i = 0; i < part.size(); ++i)
      for (const Index k : of_[part[i]])
        conditions_[k].each([&](Index r) {
          if (!way_[r] && !seen[r]) seen[r] = 1, part.push_back(r);
        });
    for (std::int64_t now = kFirstSteps;; now += now / 2) {
      const Answer answer = attempt(part, std::min(now, most - steps_));
      if (answer == Answer::found) break;
      if (answer == Answer::none || steps_ >= most || context_.stop()) return answer;
    }
  }
  return Answer::found;
}

bool GluingSearch::is_known(const GluingCondition& c) const {
  bool known = true;
  c.each([&](Index r) { known = known && way_[r]; });
  return known;
}

void GluingSearch::list_ways() {
  std::map<Index, std::vector<Index>> of_shell;
  for (const Index r : regions_) of_shell[outer_[r]].push_back(r), of_shell[inner_[r]].push_back(r);
  std::vector<Index> order;
  for (const auto& [shell, list] : of_shell) order.push_back(shell);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return sheets_[a] < sheets_[b]; });
  std::map<Index, int> named;  // 1: along the tree
  std::vector<char> first(outer_.size(), 0), sorted(outer_.size(), 0);
  std::vector<Index> queue;
  for (const Index s : order)
    if (sheets_[s] <= 1) named[s] = 1, queue.push_back(s);
  for (std::size_t head = 0, root = 0;;) {
    for (; head < queue.size(); ++head)
      for (const Index r : of_shell[queue[head]]) {
        if (outer_[r] == queue[head] && named.try_emplace(inner_[r], 1).second)
          first[r] = 1, queue.push_back(inner_[r]);
        else if (inner_[r] == queue[head] && named.try_emplace(outer_[r], 1).second)
          sorted[r] = 1, queue.push_back(outer_[r]);
      }
    while (root < order.size() && named.count(order[root])) ++root;
    if (root == order.size()) break;
    named[order[root]] = 1;
    queue.push_back(order[root]);
  }
  for (const Index r : regions_) {
    const int n = sheets_[outer_[r]];
    if (outer_[r] == inner_[r]) {
      Way way(n);
      std::iota(way.begin(), way.end(), static_cast<signed char>(0));
      do ways_[r].push_back(way);
      while (std::next_permutation(way.begin(), way.end()));
      continue;
    }
    for (int ends = n; ends >= 0; --ends) {
      Way way;
      for (int c = 0; c <= n; ++c)
        if (c != ends) way.push_back(static_cast<signed char>(c));
      do ways_[r].push_back(way);
      while (!first[r] && !sorted[r] && std::next_permutation(way.begin(), way.end()));
      if (first[r]) break;
    }
    if (ways_[r].size() == 1) way_[r] = &ways_[r][0];
  }
}

std::vector<Index> GluingSearch::possible(Index r, Index& blame) {
  std::vector<Index> out;
  steps_ += static_cast<std::int64_t>(ways_[r].size());
  for (std::size_t o = 0; o < ways_[r].size(); ++o) {
    way_[r] = &ways_[r][o];
    bool fits = true;
    for (const Index k : of_[r]) {
      if (!is_known(conditions_[k]) || holds(conditions_[k], way_)) continue;
      used_[k] = 1;
      blame = k;
      fits = false;
      break;
    }
    if (fits) out.push_back(static_cast<Index>(o));
  }
  way_[r] = nullptr;
  return out;
}

GluingSearch::Answer GluingSearch::attempt(const std::vector<Index>& part, std::int64_t most) {
  std::fill(used_.begin(), used_.end(), 0);
  struct Level {
    Index region;
    std::vector<Index> ways;
    std::size_t next = 0;
  };
  std::vector<Level> levels;
  const std::size_t n = part.size();
  std::map<Index, std::size_t> at;
  for (std::size_t i = 0; i < n; ++i) at[part[i]] = i;
  std::vector<std::vector<Index>> left(n);
  std::vector<Index> blame(n, -1);
  std::vector<char> stale(n, 1);
  const auto spoil = [&](Index r) {
    for (const Index k : of_[r])
      conditions_[k].each([&](Index other) {
        if (const auto it = at.find(other); it != at.end()) stale[it->second] = 1;
      });
  };
  const std::int64_t end = steps_ + most;
  std::int64_t chosen = 0;
  const auto leave = [&](Answer answer) {
    if (answer != Answer::found)
      for (const Level& level : levels) way_[level.region] = nullptr;
    return answer;
  };
  for (;;) {
    std::size_t best = n;
    double best_key = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (way_[part[i]]) continue;
      if (stale[i]) left[i] = possible(part[i], blame[i]), stale[i] = 0;
      double weight = 0;
      for (const Index k : of_[part[i]]) weight += weight_[k];
      const double key = left[i].size() <= 1 ? -1 : static_cast<double>(left[i].size()) / weight;
      if (best == n || key < best_key || left[i].empty()) best = i, best_key = key;
      if (left[i].empty()) break;
    }
    if (best == n) return Answer::found;
    if (left[best].empty())
      ++weight_[blame[best]];
    else
      levels.push_back({part[best], left[best]});
    for (;;) {
      if (levels.empty()) return Answer::none;
      Level& level = levels.back();
      if (way_[level.region]) spoil(level.region);
      way_[level.region] = nullptr;
      if (level.next < level.ways.size()) {
        way_[level.region] = &ways_[level.region][level.ways[level.next++]];
        spoil(level.region);
        if (steps_ > end || (++chosen % 256 == 0 && context_.stop())) return leave(Answer::too_long);
        break;
      }
      stale[at[level.region]] = 1;
      levels.pop_back();
    }
  }
}

}  // namespace overtet

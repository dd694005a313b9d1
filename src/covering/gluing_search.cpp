#include "src/covering/gluing_search.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "src/covering/tuning.h"

namespace overtet {

namespace {

int ending(const Way& way) {
  int sum = 0;
  for (const int c : way) sum += c;
  const int n = static_cast<int>(way.size());
  return n * (n + 1) / 2 - sum;
}

int inverse(const Way& way, int x) {
  return static_cast<int>(std::find(way.begin(), way.end(), x) - way.begin());
}

enum class Passage { forth, back };

// The name that layer x has on the other side of a sector.
int across(const GluingCondition& c, const std::vector<const Way*>& ways, int sector, int x,
           Passage passage = Passage::forth) {
  if (c.names[sector] < 0) return x;
  const Way& way = *ways[c.names[sector]];
  return (passage == Passage::back) != (c.backwards[sector] != 0) ? inverse(way, x)
                                                                  : static_cast<int>(way[x]);
}

}  // namespace

bool holds(const GluingCondition& c, const std::vector<const Way*>& ways) {
  if (c.most >= 0) return turns_at(c, ways).has_value();
  const auto go = [&](int sector, int x, Passage passage = Passage::forth) {
    return across(c, ways, sector, x, passage);
  };
  const Way &fp = *ways[c.regions[0]], &gp = *ways[c.regions[1]], &fm = *ways[c.regions[2]],
            &gm = *ways[c.regions[3]];
  for (int k = 0; k < static_cast<int>(fp.size()); ++k)
    if (go(3, fm[go(2, gp[go(0, k)], Passage::back)]) != gm[go(1, fp[k])]) return false;
  return gm[go(1, ending(fp))] == go(3, ending(fm)) &&
         go(3, fm[go(2, ending(gp), Passage::back)]) == ending(gm);
}

std::optional<int> turns_at(const GluingCondition& c, const std::vector<const Way*>& ways) {
  // The second part in the names of the first.
  const Way &l = *ways[c.regions[0]], &other = *ways[c.regions[1]];
  Way r(l.size());
  for (int k = 0; k < static_cast<int>(l.size()); ++k)
    r[k] = static_cast<signed char>(across(c, ways, 1, other[across(c, ways, 0, k)], Passage::back));
  unsigned passed = 0;
  int at = ending(l), turns = 0;
  const int end = ending(r);
  while (at != end) {
    const int back = inverse(r, at);
    passed |= 1u << back;
    at = l[back];
    if (++turns > c.most) return std::nullopt;
  }
  for (std::size_t k = 0; k < l.size(); ++k)
    if (!(passed >> k & 1) && l[k] != r[k]) return std::nullopt;
  return turns;
}

GluingSearch::GluingSearch(std::vector<GluingCondition> conditions,
                           const std::vector<std::array<Index, 2>>& cells, const std::vector<int>& layers,
                           const RunContext& context, Accept accept)
    : conditions_(std::move(conditions)),
      cells_(cells),
      layers_(layers),
      context_(context),
      accept_(std::move(accept)) {
  const std::size_t n = cells.size();
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

SolverAnswer GluingSearch::run(std::int64_t most) {
  for (std::size_t k = 0; k < conditions_.size(); ++k)
    if (is_known(conditions_[k]) && !holds(conditions_[k], way_)) {
      used_[k] = 1;
      return SolverAnswer::none;
    }
  // Independent parts one after the other, but for what must be accepted as a whole.
  std::vector<char> seen(of_.size(), 0);
  for (const Index seed : regions_) {
    if (way_[seed] || seen[seed]) continue;
    std::vector<Index> part{seed};
    seen[seed] = 1;
    const auto add = [&](Index r) {
      if (!way_[r] && !seen[r]) seen[r] = 1, part.push_back(r);
    };
    for (std::size_t i = 0; i < part.size(); ++i)
      for (const Index k : of_[part[i]]) conditions_[k].each(add);
    if (accept_)
      for (const Index r : regions_) add(r);
    for (std::int64_t now = kFirstSteps;; now += now / 2) {
      std::fill(used_.begin(), used_.end(), 0);
      work_.chosen = 0;
      work_.end = work_.steps + std::min(now, most - work_.steps);
      const SolverAnswer answer = GluingSolver(*this, part).run(FirstLook::until_stuck);
      if (answer == SolverAnswer::found) break;
      if (answer == SolverAnswer::none || work_.steps >= most || context_.stop()) return answer;
    }
  }
  return SolverAnswer::found;
}

bool GluingSearch::is_known(const GluingCondition& c) const {
  bool known = true;
  c.each([&](Index r) { known = known && way_[r]; });
  return known;
}

void GluingSearch::list_ways() {
  const std::vector<Named> named = name_layers(regions_, cells_, layers_);
  for (std::size_t i = 0; i < regions_.size(); ++i) {
    const Index r = regions_[i];
    const int n = layers_[cells_[r][0]];
    if (cells_[r][0] == cells_[r][1]) {
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
      while (named[i] == Named::neither && std::next_permutation(way.begin(), way.end()));
      if (named[i] == Named::back) break;
    }
    if (ways_[r].size() == 1) way_[r] = &ways_[r][0];
  }
}

std::optional<std::vector<Index>> GluingSearch::possible(Index r, Index& blame) {
  std::vector<Index> out;
  work_.steps += static_cast<std::int64_t>(ways_[r].size());
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

// Fewer ways for the weight of its conditions come first.
double GluingSearch::rank(Index r, std::size_t options) const {
  if (options == 0) return 0;
  if (options == 1) return std::numeric_limits<double>::min();
  double weight = 0;
  for (const Index k : of_[r]) weight += weight_[k];
  return static_cast<double>(options) / weight;
}

bool GluingSearch::exhausted() {
  return work_.steps > work_.end || (++work_.chosen % 256 == 0 && context_.stop());
}

}  // namespace overtet

#include "src/immersion/sheet_search.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>

#include "kernels/core/tuning.h"
#include "src/covering/tuning.h"
#include "src/immersion/tuning.h"

namespace overtet {

SheetSearch::SheetSearch(const std::vector<Region>& regions, const std::vector<Index>& winding,
                         const SheetPuzzle& puzzle, const RunContext& context, std::int64_t most_nodes)
    : regions_(regions), winding_(winding), puzzle_(puzzle), context_(context), most_nodes_(most_nodes) {}

bool SheetSearch::solve() {
  const Index n = static_cast<Index>(regions_.size());
  std::vector<Index> all(regions_.size());
  std::iota(all.begin(), all.end(), 0);
  named_ = name_layers(all, puzzle_.cells, winding_);
  options_.resize(n);
  listed_.assign(n, 1);
  known_.assign(n, {});
  for (Index r = 0; r < n; ++r) {
    const double count = count_gluings(regions_[r], named_[r]);
    if (count > kMostListed) {
      listed_[r] = 0;
      continue;
    }
    if (count > 0) {
      enumerate_gluings(regions_[r], named_[r], options_[r]);
      continue;
    }
    cut_short_ = true;
    impossible_region_ = r;
    return false;
  }
  chosen_.assign(n, nullptr);
  for (Index r = 0; r < n; ++r)
    if (listed_[r] && options_[r].size() == 1) chosen_[r] = &options_[r][0];

  fans_of_.assign(n, {});
  for (Index c = 0; c < static_cast<Index>(puzzle_.fans.size()); ++c) {
    std::vector<Index> members;
    for (const auto& leaf : puzzle_.fans[c].leaves) members.push_back(leaf.region);
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    bool open = false;
    for (const Index r : members) open |= !chosen_[r];
    if (!open) {
      if (!satisfied(puzzle_.fans[c], chosen_, regions_)) {
        deepest_fan_ = c;
        return false;
      }
      continue;
    }
    for (const Index r : members)
      if (!chosen_[r]) fans_of_[r].push_back(c);
    open_members_.emplace(c, std::move(members));
  }
  free_fans_of_.assign(n, {});
  for (Index i = 0; i < static_cast<Index>(puzzle_.free_fans.size()); ++i)
    for (const auto& leaf : puzzle_.free_fans[i].fan.leaves) {
      auto& list = free_fans_of_[leaf.region];
      if (list.empty() || list.back() != i) list.push_back(i);
    }
  links_of_.assign(n, {});
  for (Index i = 0; i < static_cast<Index>(puzzle_.links.size()); ++i) {
    const VertexLink& link = puzzle_.links[i];
    if (is_complete(link)) {
      if (!makes_discs(link, chosen_, regions_)) return false;
      continue;
    }
    for (const VertexLink::Arc& arc : link.arcs) {
      auto& list = links_of_[arc.region];
      if (list.empty() || list.back() != i) list.push_back(i);
    }
  }
  // Independent parts one after the other.
  std::vector<char> seen(n, 0);
  for (Index seed = 0; seed < n; ++seed) {
    if (chosen_[seed] || seen[seed]) continue;
    std::vector<Index> part{seed};
    seen[seed] = 1;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const auto add = [&](Index r) {
        if (!chosen_[r] && !seen[r]) seen[r] = 1, part.push_back(r);
      };
      for (const Index c : fans_of_[part[i]])
        for (const Index r : open_members_.at(c)) add(r);
      for (const Index c : free_fans_of_[part[i]])
        for (const auto& leaf : puzzle_.free_fans[c].fan.leaves) add(leaf.region);
      for (const Index c : links_of_[part[i]])
        for (const auto& arc : puzzle_.links[c].arcs) add(arc.region);
    }
    deepest_fan_ = fans_of_[seed].empty() ? -1 : fans_of_[seed][0];
    if (!search(part)) return false;
  }
  return true;
}

// Options of r that no fan with all other regions chosen rejects. None, where r has no list and nothing
// around it is known.
std::optional<std::vector<Index>> SheetSearch::possible(Index r, Index& blame) {
  std::vector<Index> candidates;
  if (listed_[r]) {
    candidates.resize(options_[r].size());
    std::iota(candidates.begin(), candidates.end(), 0);
  } else if (auto made = make_options(r)) {
    candidates = std::move(*made);
  } else {
    return std::nullopt;
  }
  std::vector<Index> out;
  std::vector<std::pair<double, Index>> costs;
  for (const Index o : candidates) {
    chosen_[r] = &options_[r][o];
    bool fits = true;
    for (const Index c : fans_of_[r]) {
      if (is_complete(puzzle_.fans[c]) && !satisfied(puzzle_.fans[c], chosen_, regions_)) {
        fits = false;
        deepest_fan_ = blame = c;
        break;
      }
    }
    // Free edges: some number of turns must fit; options that need the fewest unproposed ones come first.
    double cost = 0;
    for (const Index c : free_fans_of_[r]) {
      if (!fits) break;
      const FreeFan& f = puzzle_.free_fans[c];
      if (!is_complete(f.fan)) continue;
      const int turns = turns_at(f);
      fits = turns >= 0;
      if (!fits) blame = static_cast<Index>(puzzle_.fans.size()) + c;
      cost += (turns != f.given) + (turns > 0 && f.pierced ? kFarMore : 0);
    }
    if (fits && fits_links(r, blame)) costs.emplace_back(cost, o);
  }
  looks_ += static_cast<std::int64_t>(candidates.size());
  chosen_[r] = nullptr;
  std::sort(costs.begin(), costs.end());
  for (const auto& [cost, o] : costs) out.push_back(o);
  return out;
}

// But for the region `open`.
bool SheetSearch::is_complete(const Fan& fan, Index open) const {
  return std::all_of(fan.leaves.begin(), fan.leaves.end(),
                     [&](const Fan::Leaf& l) { return l.region == open || chosen_[l.region]; });
}

bool SheetSearch::is_complete(const VertexLink& link) const {
  return std::all_of(link.arcs.begin(), link.arcs.end(),
                     [&](const VertexLink::Arc& a) { return chosen_[a.region]; });
}

// As far as all others at them are chosen.
bool SheetSearch::fits_links(Index r, Index& blame) const {
  for (const Index i : links_of_[r]) {
    if (!is_complete(puzzle_.links[i]) || makes_discs(puzzle_.links[i], chosen_, regions_)) continue;
    blame = static_cast<Index>(puzzle_.fans.size() + puzzle_.free_fans.size()) + i;
    return false;
  }
  return true;
}

// For a region without a list: the gluings that a fan allows in which all others are chosen.
std::optional<std::vector<Index>> SheetSearch::make_options(Index r) {
  const auto once = [&](const Fan& fan) {
    return std::count_if(fan.leaves.begin(), fan.leaves.end(),
                         [&](const Fan::Leaf& l) { return l.region == r; }) == 1;
  };
  for (const Index c : fans_of_[r]) {
    const Fan& fan = puzzle_.fans[c];
    int turns = 0;
    for (const Fan::Pass& pass : fan.passes) turns += pass.turns;
    if (turns > 2 * kMostTurnsMade || !once(fan) || !is_complete(fan, r)) continue;  // passes come twice
    if (auto made = options_around(fan, r, turns)) return made;
  }
  for (const Index c : free_fans_of_[r]) {
    const Fan& fan = puzzle_.free_fans[c].fan;
    if (!once(fan) || !is_complete(fan, r)) continue;
    const bool all = count_gluings(regions_[r], named_[r]) <= kMostTurned;
    if (!all) cut_short_ = true;
    const int most = std::min(regions_[r].front_winding, regions_[r].back_winding);
    if (auto made = options_around(fan, r, all ? most : kMostTurnsMade)) return made;
  }
  return std::nullopt;
}

// Copies that come back to the region on the other side, having gone around the edge, must close there; the
// few that begin or end on the way are joined in all ways. One more turn: a copy on such a path and one
// that closes exchange what they lead to.
std::optional<std::vector<Index>> SheetSearch::options_around(const Fan& fan, Index r, int turns) {
  const Region& region = regions_[r];
  const int front = region.front_winding, back = region.back_winding;
  int at = 0;
  while (fan.leaves[at].region != r) ++at;
  const bool flipped = fan.leaves[at].flipped;
  // Targets: back copies, then -1 - slot. Sources: front copies, then slots that begin on the back.
  std::vector<int> target(front, -100);
  std::vector<int> loose;  // targets that no front copy has yet
  for (int b = 0; b < back; ++b) {
    int leaf = at, side = flipped ? 0 : 1, copy = b;
    for (;;) {
      const int arrival = fan.arc[leaf][side];
      if (arrival < 0) return std::nullopt;
      leaf = arrival / 2, side = arrival % 2;
      if (leaf == at) break;
      const Fan::Leaf& l = fan.leaves[leaf];
      const Gluing& option = *chosen_[l.region];
      copy = ((side == 0) != l.flipped ? option.back_of : option.front_of)[copy];
      if (copy < 0) break;
      side = 1 - side;
    }
    if (copy >= 0 && (side == 0) == flipped) return std::nullopt;
    if (copy >= 0)
      target[copy] = b;
    else
      loose.push_back(b);
  }
  std::vector<int> open;  // sources without a target
  for (int f = 0; f < front; ++f)
    if (target[f] == -100) open.push_back(f);
  const std::size_t copies = open.size();
  for (int s = 0; s < static_cast<int>(region.signs.size()); ++s)
    (region.signs[s] > 0 ? open : loose).push_back(region.signs[s] > 0 ? front + s : -1 - s);
  if (open.size() != loose.size() || open.size() > kMostOpen) return std::nullopt;

  struct Made {
    std::vector<int> target;  // of the front copies, then of the slots
    std::vector<int> path;    // sources on paths that begin or end
  };
  std::vector<Made> made;
  target.resize(front + region.signs.size(), -100);
  std::sort(loose.begin(), loose.end());
  do {
    bool fits = true;  // a slot cannot begin where another one ends
    for (std::size_t i = copies; i < open.size(); ++i) fits = fits && loose[i] >= 0;
    if (!fits) continue;
    made.push_back({target, open});
    for (std::size_t i = 0; i < open.size(); ++i) made.back().target[open[i]] = loose[i];
  } while (std::next_permutation(loose.begin(), loose.end()));
  for (std::size_t begin = 0; turns > 0; --turns) {
    const std::size_t end = made.size();
    for (std::size_t i = begin; i < end; ++i)
      for (const int x : std::vector<int>(made[i].path))
        for (int f = 0; f < front; ++f) {
          const Made& now = made[i];
          if (std::find(now.path.begin(), now.path.end(), f) != now.path.end()) continue;
          Made more = now;
          std::swap(more.target[x], more.target[f]);
          more.path.push_back(f);
          if (x >= front && more.target[x] < 0) continue;
          made.push_back(std::move(more));
          if (static_cast<double>(made.size()) <= kMostOptions) continue;
          cut_short_ = true;
          return std::nullopt;
        }
    begin = end;
  }
  looks_ += kLooksToMake * static_cast<std::int64_t>(made.size());
  std::vector<Index> out;
  for (const Made& m : made) {
    Gluing option{std::vector<int>(front, -100), std::vector<int>(back, -100)};
    for (int x = 0; x < static_cast<int>(m.target.size()); ++x) {
      const int to = m.target[x];
      if (to == -100) continue;
      if (x < front) option.back_of[x] = to;
      if (to >= 0) option.front_of[to] = x < front ? x : -1 - (x - front);
    }
    std::vector<int> key = option.back_of;
    key.insert(key.end(), option.front_of.begin(), option.front_of.end());
    const auto [place, is_new] =
        known_[r].try_emplace(std::move(key), static_cast<Index>(options_[r].size()));
    if (is_new) options_[r].push_back(std::move(option));
    out.push_back(place->second);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Extra turns at a free edge under the present choice; -1: none fits.
int SheetSearch::turns_at(const FreeFan& f) const {
  const Region& r = regions_[f.fan.leaves[0].region];
  const int most = std::min(r.front_winding, r.back_winding);
  for (int turns = 0; turns <= most; ++turns)
    if (satisfied(f.fan, chosen_, regions_, turns)) return turns;
  return -1;
}

// Lists all options of a region; false when there are too many.
bool SheetSearch::list_options(Index r) {
  if (count_gluings(regions_[r], named_[r]) > kMostOptions) {
    cut_short_ = true;
    return false;
  }
  options_[r].clear();
  known_[r].clear();
  enumerate_gluings(regions_[r], named_[r], options_[r]);
  listed_[r] = 1;
  return true;
}

// A first attempt goes on where it has been. Those that follow begin where the ones before have failed
// most.
bool SheetSearch::search(const std::vector<Index>& part) {
  const bool all_listed = std::all_of(part.begin(), part.end(), [&](Index r) { return listed_[r] != 0; });
  const std::int64_t n = static_cast<std::int64_t>(part.size());
  const std::int64_t first =
      all_listed ? kFirstNodes + kFirstNodesEach * n : kFirstNodes + kMostNodesMade * n;
  const std::int64_t last = nodes_ + (all_listed ? most_nodes_ : kInVain * first);
  weight_.assign(puzzle_.fans.size() + puzzle_.free_fans.size(), 1);
  weight_.resize(weight_.size() + puzzle_.links.size(), 0);
  by_weight_ = false;
  for (std::int64_t most = first;; most += most / 2, by_weight_ = true) {
    end_ = nodes_ + std::min(most, last - nodes_);
    const SolverAnswer found = GluingSolver(*this, part).run(true);
    if (found == SolverAnswer::found) return true;
    if (found == SolverAnswer::none) return false;
    if (nodes_ < last && !worn_out() && !context_.stop()) continue;
    cut_short_ = true;
    return false;
  }
}

// Options left; a region's share of dead ends makes them fewer.
double SheetSearch::rank(Index r, std::size_t options) const {
  const double n = static_cast<double>(options);
  if (!by_weight_ || n < 2) return n;
  double weight = 0;
  for (const Index c : fans_of_[r]) weight += weight_[c];
  for (const Index c : free_fans_of_[r]) weight += weight_[puzzle_.fans.size() + c];
  for (const Index c : links_of_[r]) weight += weight_[puzzle_.fans.size() + puzzle_.free_fans.size() + c];
  return 1 + n / (1 + weight);
}

bool SheetSearch::exhausted() {
  return ++nodes_ > end_ || worn_out() || (nodes_ % 256 == 0 && context_.stop());
}

std::set<std::pair<Index, Index>> SheetSearch::settle_free_fans() {
  const auto cost = [&](Index r) {
    double sum = 0;
    for (const Index i : free_fans_of_[r]) {
      const int turns = turns_at(puzzle_.free_fans[i]);
      if (turns < 0) return std::numeric_limits<double>::infinity();
      sum += turns * (puzzle_.free_fans[i].pierced ? kFarMore : 1.0);
    }
    return sum;
  };
  for (bool better = true; better;) {
    better = false;
    for (Index r = 0; r < static_cast<Index>(regions_.size()); ++r) {
      if (options_[r].size() < 2 || free_fans_of_[r].empty()) continue;
      const Gluing* now = chosen_[r];
      double best = cost(r);
      const Gluing* choice = now;
      for (const Gluing& option : options_[r]) {
        chosen_[r] = &option;
        const bool fits = std::all_of(fans_of_[r].begin(), fans_of_[r].end(),
                                      [&](Index c) { return satisfied(puzzle_.fans[c], chosen_, regions_); });
        Index blame = -1;
        if (!fits || !fits_links(r, blame)) continue;
        if (const double there = cost(r); there < best) best = there, choice = &option;
      }
      chosen_[r] = choice;
      better |= choice != now;
    }
  }
  std::map<std::pair<Index, Index>, int> turns;
  std::set<std::pair<Index, Index>> torn;
  for (const FreeFan& f : puzzle_.free_fans) {
    const int here = turns_at(f);
    if (turns.try_emplace(f.edge, here).first->second == here && here >= 0) continue;
    torn.insert(f.edge);
  }
  return torn;
}

}  // namespace overtet

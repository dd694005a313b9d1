#include "src/immersion/sheet_search.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>

#include "kernels/core/tuning.h"
#include "src/immersion/tuning.h"

namespace overtet {

SheetSearch::SheetSearch(const std::vector<Region>& regions, const std::vector<Index>& winding,
                         const SheetPuzzle& puzzle, const RunContext& context)
    : regions_(regions), winding_(winding), puzzle_(puzzle), context_(context) {}

bool SheetSearch::solve() { return list_gluings() && gather_conditions() && search_parts(); }

bool SheetSearch::settle() {
  if (!list_gluings() || !gather_conditions()) return false;
  std::vector<Index> open;
  for (Index r = 0; r < static_cast<Index>(regions_.size()); ++r)
    if (!chosen_[r]) open.push_back(r);
  weights_.of.assign(puzzle_.fans.size() + puzzle_.links.size(), 1);
  work_.end = kMostNodes;
  return GluingSolver(*this, open).run(FirstLook::at_all, SolverGoal::what_follows) != SolverAnswer::none;
}

// Of every region that has not too many; chooses where there is one only. False: a region has none.
bool SheetSearch::list_gluings() {
  const Index n = static_cast<Index>(regions_.size());
  std::vector<Index> all(regions_.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<Named> named = name_layers(all, puzzle_.cells, winding_);
  options_.resize(n);
  for (Index r = 0; r < n; ++r) {
    Options& options = options_[r];
    options.named = named[r];
    const double count = count_gluings(regions_[r], named[r]);
    if (count > kMostListed) {
      options.listed = false;
      continue;
    }
    if (count > 0) {
      enumerate_gluings(regions_[r], named[r], options.gluings);
      continue;
    }
    failure_.cut_short = true;
    failure_.impossible_region = r;
    return false;
  }
  chosen_.assign(n, nullptr);
  for (Index r = 0; r < n; ++r)
    if (options_[r].listed && options_[r].gluings.size() == 1) chosen_[r] = &options_[r].gluings[0];
  return true;
}

// False: what is chosen from the start does not fit.
bool SheetSearch::gather_conditions() {
  const auto add = [](std::vector<Index>& list, Index i) {
    if (list.empty() || list.back() != i) list.push_back(i);
  };
  around_.assign(regions_.size(), {});
  for (Index c = 0; c < static_cast<Index>(puzzle_.fans.size()); ++c) {
    std::vector<Index> members;
    for (const auto& leaf : puzzle_.fans[c].leaves) members.push_back(leaf.region);
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    bool open = false;
    for (const Index r : members) open |= !chosen_[r];
    if (!open) {
      if (!satisfied(puzzle_.fans[c], chosen_, regions_)) {
        failure_.deepest_fan = c;
        return false;
      }
      continue;
    }
    for (const Index r : members)
      if (!chosen_[r]) around_[r].fans.push_back(c);
    open_members_.emplace(c, std::move(members));
  }
  for (Index i = 0; i < static_cast<Index>(puzzle_.links.size()); ++i) {
    const VertexLink& link = puzzle_.links[i];
    if (is_complete(link)) {
      if (!makes_discs(link, chosen_, regions_)) return false;
      continue;
    }
    for (const VertexLink::Arc& arc : link.arcs) add(around_[arc.region].links, i);
  }
  return true;
}

// Independent parts one after the other.
bool SheetSearch::search_parts() {
  const Index n = static_cast<Index>(regions_.size());
  std::vector<char> seen(n, 0);
  for (Index seed = 0; seed < n; ++seed) {
    if (chosen_[seed] || seen[seed]) continue;
    std::vector<Index> part{seed};
    seen[seed] = 1;
    const auto add = [&](Index r) {
      if (!chosen_[r] && !seen[r]) seen[r] = 1, part.push_back(r);
    };
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Around& around = around_[part[i]];
      for (const Index c : around.fans)
        for (const Index r : open_members_.at(c)) add(r);
      for (const Index c : around.links)
        for (const auto& arc : puzzle_.links[c].arcs) add(arc.region);
    }
    failure_.deepest_fan = around_[seed].fans.empty() ? -1 : around_[seed].fans[0];
    if (!search(part)) return false;
  }
  return true;
}

// Options of r that no fan with all other regions chosen rejects. None, where r has no list and nothing
// around it is known.
std::optional<std::vector<Index>> SheetSearch::possible(Index r, Index& blame) {
  std::vector<Index> candidates;
  if (options_[r].listed) {
    candidates.resize(options_[r].gluings.size());
    std::iota(candidates.begin(), candidates.end(), 0);
  } else if (auto made = make_options(r)) {
    candidates = std::move(*made);
  } else {
    return std::nullopt;
  }
  std::vector<Index> out;
  for (const Index o : candidates) {
    chosen_[r] = &options_[r].gluings[o];
    bool fits = true;
    for (const Index c : around_[r].fans) {
      if (is_complete(puzzle_.fans[c]) && !satisfied(puzzle_.fans[c], chosen_, regions_)) {
        fits = false;
        failure_.deepest_fan = blame = c;
        break;
      }
    }
    if (fits && fits_links(r, blame)) out.push_back(o);
  }
  work_.looks += static_cast<std::int64_t>(candidates.size());
  chosen_[r] = nullptr;
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
  for (const Index i : around_[r].links) {
    if (!is_complete(puzzle_.links[i]) || makes_discs(puzzle_.links[i], chosen_, regions_)) continue;
    blame = static_cast<Index>(puzzle_.fans.size()) + i;
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
  for (const Index c : around_[r].fans) {
    const Fan& fan = puzzle_.fans[c];
    int turns = 0;
    for (const Fan::Pass& pass : fan.passes) turns += pass.turns;
    if (turns > 2 * kMostTurnsMade || !once(fan) || !is_complete(fan, r)) continue;  // passes come twice
    if (auto made = options_around(fan, r, turns)) return made;
  }
  return std::nullopt;
}

// Follows the copies behind a region around the edge, to the region's other side or to where they end.
std::optional<SheetSearch::Ends> SheetSearch::ends_around(const Fan& fan, Index r) const {
  const Region& region = regions_[r];
  int at = 0;
  while (fan.leaves[at].region != r) ++at;
  const bool flipped = fan.leaves[at].flipped;
  Ends out;
  out.target.assign(region.front_winding, kNowhere);
  for (int b = 0; b < region.back_winding; ++b) {
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
      out.target[copy] = b;
    else
      out.loose.push_back(b);
  }
  for (int f = 0; f < region.front_winding; ++f)
    if (out.target[f] == kNowhere) out.open.push_back(f);
  out.copies = out.open.size();
  for (int s = 0; s < static_cast<int>(region.signs.size()); ++s)
    (region.signs[s] > 0 ? out.open : out.loose)
        .push_back(region.signs[s] > 0 ? region.front_winding + s : -1 - s);
  out.target.resize(region.front_winding + region.signs.size(), kNowhere);
  std::sort(out.loose.begin(), out.loose.end());
  return out;
}

// What is open with what is loose, in all ways.
std::vector<SheetSearch::Made> SheetSearch::join_ends(Ends ends) {
  std::vector<Made> made;
  do {
    bool fits = true;  // a slot cannot begin where another one ends
    for (std::size_t i = ends.copies; i < ends.open.size(); ++i) fits = fits && ends.loose[i] >= 0;
    if (!fits) continue;
    made.push_back({ends.target, ends.open});
    for (std::size_t i = 0; i < ends.open.size(); ++i) made.back().target[ends.open[i]] = ends.loose[i];
  } while (std::next_permutation(ends.loose.begin(), ends.loose.end()));
  return made;
}

// Appends what one more turn makes of those from `begin` on: a copy on a path that begins or ends and one
// that closes exchange what they lead to. False: too many. front: the number of front copies.
bool SheetSearch::add_turn(std::vector<Made>& made, std::size_t begin, int front) {
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
        if (static_cast<double>(made.size()) > kMostOptions) return false;
      }
  return true;
}

// Their numbers among the options of r, new ones added.
std::vector<Index> SheetSearch::take_in(const std::vector<Made>& made, Index r) {
  const int front = regions_[r].front_winding, back = regions_[r].back_winding;
  Options& options = options_[r];
  std::vector<Index> out;
  for (const Made& m : made) {
    Gluing option{std::vector<int>(front, kNowhere), std::vector<int>(back, kNowhere)};
    for (int x = 0; x < static_cast<int>(m.target.size()); ++x) {
      const int to = m.target[x];
      if (to == kNowhere) continue;
      if (x < front) option.back_of[x] = to;
      if (to >= 0) option.front_of[to] = x < front ? x : -1 - (x - front);
    }
    std::vector<int> key = option.back_of;
    key.insert(key.end(), option.front_of.begin(), option.front_of.end());
    const auto [place, is_new] =
        options.known.try_emplace(std::move(key), static_cast<Index>(options.gluings.size()));
    if (is_new) options.gluings.push_back(std::move(option));
    out.push_back(place->second);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Copies that come back to the region on the other side, having gone around the edge, must close there; the
// few that begin or end on the way are joined in all ways.
std::optional<std::vector<Index>> SheetSearch::options_around(const Fan& fan, Index r, int turns) {
  std::optional<Ends> ends = ends_around(fan, r);
  if (!ends || ends->open.size() != ends->loose.size() || ends->open.size() > kMostOpen) return std::nullopt;
  std::vector<Made> made = join_ends(std::move(*ends));
  for (std::size_t begin = 0; turns > 0; --turns) {
    const std::size_t end = made.size();
    if (!add_turn(made, begin, regions_[r].front_winding)) {
      failure_.cut_short = true;
      return std::nullopt;
    }
    begin = end;
  }
  work_.looks += kLooksToMake * static_cast<std::int64_t>(made.size());
  return take_in(made, r);
}

// Lists all options of a region; false when there are too many.
bool SheetSearch::list_options(Index r) {
  if (count_gluings(regions_[r], options_[r].named) > kMostOptions) {
    failure_.cut_short = true;
    return false;
  }
  options_[r].gluings.clear();
  options_[r].known.clear();
  enumerate_gluings(regions_[r], options_[r].named, options_[r].gluings);
  options_[r].listed = true;
  return true;
}

// A first attempt goes on where it has been. Those that follow begin where the ones before have failed
// most.
bool SheetSearch::search(const std::vector<Index>& part) {
  const bool all_listed = std::all_of(part.begin(), part.end(), [&](Index r) { return options_[r].listed; });
  const std::int64_t n = static_cast<std::int64_t>(part.size());
  const std::int64_t first =
      all_listed ? kFirstNodes + kFirstNodesEach * n : kFirstNodes + kMostNodesMade * n;
  const std::int64_t last = work_.nodes + (all_listed ? kMostNodes : kInVain * first);
  weights_.of.assign(puzzle_.fans.size(), 1);
  weights_.of.resize(weights_.of.size() + puzzle_.links.size(), 0);
  weights_.count = false;
  for (std::int64_t most = first;; most += most / 2, weights_.count = true) {
    work_.end = work_.nodes + std::min(most, last - work_.nodes);
    const SolverAnswer found = GluingSolver(*this, part).run(FirstLook::at_all);
    if (found == SolverAnswer::found) return true;
    if (found == SolverAnswer::none) return false;
    if (work_.nodes < last && !worn_out() && !context_.stop()) continue;
    failure_.cut_short = true;
    return false;
  }
}

// Options left; a region's share of dead ends makes them fewer.
double SheetSearch::rank(Index r, std::size_t options) const {
  const double n = static_cast<double>(options);
  if (!weights_.count || n < 2) return n;
  double weight = 0;
  for (const Index c : around_[r].fans) weight += weights_.of[c];
  for (const Index c : around_[r].links) weight += weights_.of[puzzle_.fans.size() + c];
  return 1 + n / (1 + weight);
}

bool SheetSearch::exhausted() {
  return ++work_.nodes > work_.end || worn_out() || (work_.nodes % 256 == 0 && context_.stop());
}

}  // namespace overtet

// The search for the gluings of all regions between the cells of an arrangement: what the solver
// (src/covering/gluing_solver.h) must know about them, and restarts where dead ends were met most.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/covering/gluing_solver.h"
#include "src/immersion/edge_fan.h"
#include "src/immersion/tuning.h"
#include "src/immersion/vertex_link.h"

namespace overtet {

// An edge that may be wound: any number of extra turns that its fan allows.
struct FreeFan {
  Fan fan;
  std::pair<Index, Index> edge;  // of the input
  int given;                     // turns it was proposed to have
  bool pierced;                  // the input edge has several parts
};

// What the gluings of some regions must satisfy.
struct SheetPuzzle {
  std::vector<std::array<Index, 2>>
      cells;  // per region, in front of it and behind it; -1: outside everything
  std::vector<Fan> fans;
  std::vector<FreeFan> free_fans;
  std::vector<VertexLink> links;  // where more than fans must be seen to
};

class SheetSearch {
 public:
  // winding: of each cell. All arguments must outlive the search.
  SheetSearch(const std::vector<Region>& regions, const std::vector<Index>& winding,
              const SheetPuzzle& puzzle, const RunContext& context, std::int64_t most_nodes = kMostNodes);

  // Whether there are gluings that satisfy all fans and links; no, too, where the search is stopped or given
  // up.
  bool solve();

  // After solve() has found some: fewer wound edges. Regions change their gluing where nothing forbids it.
  // Then every part of an input edge must have the same number of turns; returned are the edges where that
  // fails.
  std::set<std::pair<Index, Index>> settle_free_fans();

  // After solve() has found some.
  const Gluing& gluing(Index region) const { return *chosen_[region]; }

  bool cut_short() const { return cut_short_; }                   // the search has not seen everything
  Index impossible_region() const { return impossible_region_; }  // that has no gluing at all; -1: none
  Index deepest_fan() const { return deepest_fan_; }  // the fan that was in the way last; -1: none
  std::int64_t nodes() const { return nodes_; }

  // For the solver; see there. Conditions: fans, then free fans, then links.
  bool is_open(Index r) const { return !chosen_[r]; }
  std::optional<std::vector<Index>> possible(Index r, Index& blame);
  bool list_options(Index r);
  void choose(Index r, Index option) { chosen_[r] = &options_[r][option]; }
  void clear(Index r) { chosen_[r] = nullptr; }
  double rank(Index r, std::size_t options) const;
  template <class F>
  void each_beside(Index r, F&& f) const;
  template <class F>
  void weigh(Index condition, F&& again);
  bool accepts() const { return true; }
  bool exhausted();

 private:
  bool worn_out() const { return looks_ > kMostGluingLooks; }

  bool is_complete(const Fan& fan, Index open = -1) const;
  bool is_complete(const VertexLink& link) const;
  bool fits_links(Index r, Index& blame) const;
  std::optional<std::vector<Index>> make_options(Index r);
  std::optional<std::vector<Index>> options_around(const Fan& fan, Index r, int turns);
  int turns_at(const FreeFan& f) const;
  bool search(const std::vector<Index>& part);

  const std::vector<Region>& regions_;
  const std::vector<Index>& winding_;
  const SheetPuzzle& puzzle_;
  const RunContext& context_;
  const std::int64_t most_nodes_;
  bool cut_short_ = false;
  std::int64_t nodes_ = 0;
  std::int64_t looks_ = 0;
  std::vector<Named> named_;                              // per region
  std::vector<std::deque<Gluing>> options_;               // addresses stay
  std::vector<char> listed_;                              // whether these are all
  std::vector<std::map<std::vector<int>, Index>> known_;  // where they are not: which there are
  std::vector<const Gluing*> chosen_;
  std::vector<std::vector<Index>> fans_of_, free_fans_of_, links_of_;  // per region
  std::map<Index, std::vector<Index>> open_members_;
  Index impossible_region_ = -1;
  Index deepest_fan_ = -1;
  std::vector<double> weight_;  // dead ends at each condition
  bool by_weight_ = false;      // ranks count them
  std::int64_t end_ = 0;        // nodes at which the present attempt ends
};

template <class F>
void SheetSearch::each_beside(Index r, F&& f) const {
  for (const Index c : fans_of_[r])
    for (const Index other : open_members_.at(c)) f(other, 0);
  for (const Index c : free_fans_of_[r])
    for (const auto& leaf : puzzle_.free_fans[c].fan.leaves) f(leaf.region, 1);
  // A link rejects nothing before all but one are chosen.
  for (const Index c : links_of_[r]) {
    Index last = -1;
    bool several = false;
    for (const auto& arc : puzzle_.links[c].arcs) {
      if (chosen_[arc.region] || arc.region == r || arc.region == last) continue;
      several = several || last >= 0;
      last = arc.region;
    }
    if (last >= 0 && !several) f(last, 0);
  }
}

template <class F>
void SheetSearch::weigh(Index condition, F&& again) {
  ++weight_[condition];
  if (!by_weight_) return;
  const Index free = condition - static_cast<Index>(puzzle_.fans.size());
  const Index link = free - static_cast<Index>(puzzle_.free_fans.size());
  if (free < 0)
    for (const Index r : open_members_.at(condition)) again(r);
  else if (link < 0)
    for (const auto& leaf : puzzle_.free_fans[free].fan.leaves) again(leaf.region);
  else
    for (const auto& arc : puzzle_.links[link].arcs) again(arc.region);
}

}  // namespace overtet

// The search for the gluings of all regions between the cells of an arrangement where the wound edges are
// known: what the solver (src/covering/gluing_solver.h) must know about them, and restarts where dead ends
// were met most.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/covering/gluing_solver.h"
#include "src/immersion/edge_fan.h"
#include "src/immersion/sheet_puzzle.h"
#include "src/immersion/tuning.h"

namespace overtet {

class SheetSearch {
 public:
  // winding: of each cell. All arguments must outlive the search.
  // Free fans, if there are any, do not take part.
  SheetSearch(const std::vector<Region>& regions, const std::vector<Index>& winding,
              const SheetPuzzle& puzzle, const RunContext& context);

  // Whether there are gluings that satisfy all fans and links; no, too, where the search is stopped or given
  // up.
  bool solve();

  // Only what follows from the fans without any choice. False: they contradict each other.
  bool settle();
  // Whether a region has its gluing after settle().
  bool is_settled(Index region) const { return chosen_[region] != nullptr; }

  // After solve() has found some, or where it is settled.
  const Gluing& gluing(Index region) const { return *chosen_[region]; }

  bool cut_short() const { return failure_.cut_short; }  // the search has not seen everything
  // That has no gluing at all; -1: none.
  Index impossible_region() const { return failure_.impossible_region; }
  Index deepest_fan() const { return failure_.deepest_fan; }  // the fan that was in the way last; -1: none
  std::int64_t nodes() const { return work_.nodes; }

  // For the solver; see there. Conditions: fans, then links.
  bool is_open(Index r) const { return !chosen_[r]; }
  std::optional<std::vector<Index>> possible(Index r, Index& blame);
  bool list_options(Index r);
  void choose(Index r, Index option) { chosen_[r] = &options_[r].gluings[option]; }
  void clear(Index r) { chosen_[r] = nullptr; }
  double rank(Index r, std::size_t options) const;
  template <class F>
  void each_beside(Index r, F&& f) const;
  template <class F>
  void weigh(Index condition, F&& again);
  bool accepts() const { return true; }
  bool exhausted();

 private:
  struct Options {
    Named named = Named::neither;
    std::deque<Gluing> gluings;               // addresses stay
    bool listed = true;                       // these are all
    std::map<std::vector<int>, Index> known;  // where they are not: which there are
  };
  // Conditions that a region takes part in.
  struct Around {
    std::vector<Index> fans, links;
  };
  struct Weights {
    std::vector<double> of;  // dead ends at each condition
    bool count = false;      // in ranks
  };
  struct Work {
    std::int64_t nodes = 0, looks = 0;
    std::int64_t end = 0;  // nodes at which the present attempt ends
  };
  struct Failure {
    bool cut_short = false;
    Index impossible_region = -1, deepest_fan = -1;
  };
  static constexpr int kNowhere = -100;
  // Sources are front copies, then slots that begin on the back. Targets are back copies, then -1 - slot for
  // those that end there.
  struct Ends {
    std::vector<int> target;  // of the sources, as far as paths around the edge lead to one; else kNowhere
    std::vector<int> open, loose;  // sources and targets at which paths begin or end
    std::size_t copies = 0;        // of open: front copies come first
  };
  struct Made {
    std::vector<int> target;  // of the sources
    std::vector<int> path;    // sources on paths that begin or end
  };

  bool worn_out() const { return work_.looks > kMostGluingLooks; }

  bool list_gluings();
  bool gather_conditions();
  bool search_parts();
  bool is_complete(const Fan& fan, Index open = -1) const;
  bool is_complete(const VertexLink& link) const;
  bool fits_links(Index r, Index& blame) const;
  std::optional<std::vector<Index>> make_options(Index r);
  std::optional<std::vector<Index>> options_around(const Fan& fan, Index r, int turns);
  std::optional<Ends> ends_around(const Fan& fan, Index r) const;
  static std::vector<Made> join_ends(Ends ends);
  static bool add_turn(std::vector<Made>& made, std::size_t begin, int front);
  std::vector<Index> take_in(const std::vector<Made>& made, Index r);
  bool search(const std::vector<Index>& part);

  const std::vector<Region>& regions_;
  const std::vector<Index>& winding_;
  const SheetPuzzle& puzzle_;
  const RunContext& context_;
  std::vector<Options> options_;  // per region
  std::vector<const Gluing*> chosen_;
  std::vector<Around> around_;  // per region
  std::map<Index, std::vector<Index>> open_members_;
  Weights weights_;
  Work work_;
  Failure failure_;
};

template <class F>
void SheetSearch::each_beside(Index r, F&& f) const {
  for (const Index c : around_[r].fans)
    for (const Index other : open_members_.at(c)) f(other, 0);
  // A link rejects nothing before all but one are chosen.
  for (const Index c : around_[r].links) {
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
  ++weights_.of[condition];
  if (!weights_.count) return;
  const Index link = condition - static_cast<Index>(puzzle_.fans.size());
  if (link < 0)
    for (const Index r : open_members_.at(condition)) again(r);
  else
    for (const auto& arc : puzzle_.links[link].arcs) again(arc.region);
}

}  // namespace overtet

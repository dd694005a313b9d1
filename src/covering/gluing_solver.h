// One search for all gluings: of layers around a vertex (link.h), of parts of the surface (gluing.h), and of
// regions between cells (src/immersion/sheet_search.h).
//
// Regions, each between two cells with a known number of layers, get one gluing each, an option: layers on
// one side go on into layers on the other, and some end there. Conditions around edges and corners say which
// options fit together. What the options and conditions are, and how they are found, is the problem's own
// matter: surface parts have 6 layers at most and options that can be listed; cells have more, with several
// faces in one place, and make theirs from what is around them. The search is the same.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "overtet/types.h"
#include "src/covering/next_region.h"

namespace overtet {

// Layers carry no names. Where one side's layers get theirs from a gluing, of all gluings that differ by a
// relabelling of that side one remains.
enum class Named { neither, front, back };

// For each of `regions` the side that gets its names from it: those of a spanning forest of the cells, which
// grows from the cells with the fewest layers. cells: per region, in front of it and behind it; -1: outside
// everything. layers: per cell.
std::vector<Named> name_layers(const std::vector<Index>& regions,
                               const std::vector<std::array<Index, 2>>& cells,
                               const std::vector<int>& layers);

// What the search must know. Options and conditions have numbers.
template <class P>
concept GluingProblem = requires(P& p, Index region, Index option, Index& blame,
                                 void (&beside)(Index region, int changes), void (&again)(Index region)) {
  { p.is_open(region) } -> std::same_as<bool>;  // nothing is chosen
  // Options that contradict nothing chosen, the best first. None: they are many, and nothing around the
  // region is chosen. blame: a condition that has rejected one, or -1.
  { p.possible(region, blame) } -> std::same_as<std::optional<std::vector<Index>>>;
  { p.list_options(region) } -> std::same_as<bool>;  // of a region without any; false: too many
  p.choose(region, option);
  p.clear(region);
  // The lower the sooner; 0 where there is no option.
  { p.rank(region, std::size_t{}) } -> std::same_as<double>;
  // All regions whose options may change with the region's; those with more changes come first among equals.
  p.each_beside(region, beside);
  // A condition has led to a dead end: `again` for regions whose rank is another one now.
  p.weigh(blame, again);
  { p.accepts() } -> std::same_as<bool>;    // all is chosen: whether that will do
  { p.exhausted() } -> std::same_as<bool>;  // after each choice: whether to give up
};

enum class SolverAnswer { found, none, too_long };

// How far to go: until all regions have a gluing, or only as long as a region has a single option left.
enum class SolverGoal { all, what_follows };

// Before anything is chosen: at all regions, or only up to the first one without options.
enum class FirstLook { at_all, until_stuck };

// Backtracking over some regions that are open. What is chosen next: a region without options, or else that
// of the lowest rank; ranks grow with dead ends (dom/wdeg, Boussemart and others 2004), so that a second
// attempt begins where the first has failed. After `found` all are chosen (or, if that is the goal, all that
// follows), otherwise none.
template <GluingProblem P>
class GluingSolver {
 public:
  GluingSolver(P& problem, const std::vector<Index>& regions)
      : problem_(problem),
        regions_(regions),
        left_(regions.size()),
        blame_(regions.size(), -1),
        touched_(regions.size(), 0),
        next_(regions.size()) {
    for (std::size_t i = 0; i < regions.size(); ++i) at_[regions[i]] = i, stale_.insert(i), rank(i);
  }

  SolverAnswer run(FirstLook first, SolverGoal goal = SolverGoal::all) {
    if (first == FirstLook::at_all) look_at_stale(FirstLook::at_all);
    for (;;) {
      look_at_stale(FirstLook::until_stuck);
      if (next_.none()) {
        if (problem_.accepts()) return SolverAnswer::found;
      } else {
        const std::size_t best = next_.next();
        if (goal == SolverGoal::what_follows && (!left_[best] || left_[best]->size() > 1))
          return SolverAnswer::found;
        if (!left_[best]) {
          if (!problem_.list_options(regions_[best])) return give_up(SolverAnswer::none);
          look(best);
        }
        if (!left_[best]->empty()) {
          levels_.push_back({regions_[best], *left_[best]});
          next_.take_out(best);
        } else if (blame_[best] >= 0) {
          weigh(blame_[best]);
        }
      }
      if (!advance()) return SolverAnswer::none;
      if (problem_.exhausted()) return give_up(SolverAnswer::too_long);
    }
  }

 private:
  struct Level {
    Index region;
    std::vector<Index> options;
    std::size_t next = 0;
  };

  void rank(std::size_t i) {
    next_.set(i, left_[i] ? problem_.rank(regions_[i], left_[i]->size()) : std::numeric_limits<double>::max(),
              touched_[i]);
  }

  void look(std::size_t i) {
    blame_[i] = -1;
    left_[i] = problem_.possible(regions_[i], blame_[i]);
    rank(i);
  }

  void look_at_stale(FirstLook how) {
    const bool until_stuck = how == FirstLook::until_stuck;
    for (auto it = stale_.begin();
         it != stale_.end() && !(until_stuck && next_.stuck() && next_.next() < *it);) {
      look(*it);
      it = stale_.erase(it);
    }
  }

  void weigh(Index condition) {
    problem_.weigh(condition, [&](Index r) {
      if (const auto it = at_.find(r); it != at_.end() && problem_.is_open(r)) rank(it->second);
    });
  }

  void spoil_beside(Index region) {
    problem_.each_beside(region, [&](Index r, int changes) {
      const auto it = at_.find(r);
      if (it == at_.end()) return;
      touched_[it->second] += changes;
      if (problem_.is_open(r)) stale_.insert(it->second);
    });
  }

  // Takes the next option of the deepest level that has one.
  bool advance() {
    while (!levels_.empty()) {
      Level& level = levels_.back();
      if (!problem_.is_open(level.region)) spoil_beside(level.region);
      problem_.clear(level.region);
      if (level.next < level.options.size()) {
        problem_.choose(level.region, level.options[level.next++]);
        spoil_beside(level.region);
        return true;
      }
      stale_.insert(at_[level.region]);
      levels_.pop_back();
    }
    return false;
  }

  SolverAnswer give_up(SolverAnswer answer) {
    for (const Level& level : levels_) problem_.clear(level.region);
    return answer;
  }

  P& problem_;
  const std::vector<Index>& regions_;
  std::map<Index, std::size_t> at_;
  std::vector<std::optional<std::vector<Index>>> left_;  // options; none: many
  std::vector<Index> blame_;
  std::vector<int> touched_;  // changes beside it
  NextRegion next_;
  std::set<std::size_t> stale_;  // open ones to be looked at again
  std::vector<Level> levels_;
};

}  // namespace overtet

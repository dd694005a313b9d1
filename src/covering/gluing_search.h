// Private to the .cpp files of this room: gluings of sheets that satisfy conditions at curves and edges, by
// exhaustive search. See gluing.h for what the conditions say.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// A condition on the gluings of some parts: around a piece of curve, or at an edge. Between the parts lie
// sectors; where a shell has been cut open in a sector, its sheets have other names on the other side.
struct GluingCondition {
  // Around a curve of f and g: f's part in front of g, g's in front of f, f's behind g, g's behind f. At an
  // edge: two parts, then -1.
  std::array<Index, 4> regions{-1, -1, -1, -1};
  // Names in the sectors: in front of both faces, in front of g only, in front of f only, behind both; from
  // f's part to g's. At an edge: outside, inside; from the first part to the second. -1: the same on both
  // sides.
  std::array<Index, 4> names{-1, -1, -1, -1};
  std::array<char, 4> backwards{0, 0, 0, 0};
  int most = -1;                      // turns at an edge
  Index piece = -1;                   // of a curve
  std::array<Index, 2> edge{-1, -1};  // of the input
  double weight = 1;                  // how much in the way it has been in the searches before

  template <class F>
  void each(F&& f) const {
    for (const Index r : regions)
      if (r >= 0) f(r);
    for (const Index r : names)
      if (r >= 0) f(r);
  }
};

// The sheets outside of a part go on into those inside: the number inside of each outside; one more is
// inside. Or the names of sheets across a cut.
using Way = std::vector<signed char>;

// ways: of the regions and names that the condition speaks of.
bool holds(const GluingCondition& c, const std::vector<const Way*>& ways);

// All gluings of all regions that take part in some conditions.
class GluingSearch {
 public:
  // outer, inner: the shell on each side of a region; sheets: of each shell.
  GluingSearch(std::vector<GluingCondition> conditions, const std::vector<Index>& outer,
               const std::vector<Index>& inner, const std::vector<int>& sheets, const RunContext& context);

  enum class Answer { found, none, too_long };
  std::int64_t steps() const { return steps_; }
  // Of `none`: the conditions that the search has needed, with their weights: a search for fewer begins
  // there.
  std::vector<GluingCondition> needed() const;

  // most: gluings of single regions looked at before the search gives up.
  Answer run(std::int64_t most);

 private:
  bool is_known(const GluingCondition& c) const;

  // Sheets carry no names: across the regions of a spanning forest of the shells one way stands for all that
  // differ by names.
  void list_ways();

  // The ways of r that contradict nothing; blame: a condition that one of the others contradicts.
  std::vector<Index> possible(Index r, Index& blame);

  // Backtracking. What is tried next: the region with the fewest ways for the weight of its conditions, which
  // grows with every dead end (dom/wdeg, Boussemart and others 2004), so that a second attempt begins where
  // the first has failed.
  Answer attempt(const std::vector<Index>& part, std::int64_t most);

  std::vector<GluingCondition> conditions_;
  const std::vector<Index>&outer_, &inner_;
  const std::vector<int>& sheets_;
  const RunContext& context_;
  std::vector<Index> regions_;
  std::vector<std::vector<Index>> of_;  // conditions of each region
  std::vector<std::vector<Way>> ways_;  // of each region
  std::vector<const Way*> way_;         // the one chosen
  std::vector<double> weight_;          // of each condition
  std::vector<char> used_;
  std::int64_t steps_ = 0;
};

}  // namespace overtet

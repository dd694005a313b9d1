// Private to the .cpp files of this room: gluings of layers that satisfy conditions at curves and edges, or
// at crossings and corners of a link polygon, by exhaustive search (gluing_solver.h). See gluing.h and link.h
// for what the conditions say.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/covering/gluing_solver.h"

namespace overtet {

// A condition on the gluings of some parts: around a piece of curve, or at an edge. Between the parts lie
// sectors; where a shell has been cut open in a sector, its layers have other names on the other side.
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

// The layers outside of a part go on into those inside: the number inside of each outside; one more is
// inside. Or the names of layers across a cut.
using Way = std::vector<signed char>;

// ways: of the regions and names that the condition speaks of.
bool holds(const GluingCondition& c, const std::vector<const Way*>& ways);

// At an edge: how often the layer that begins at one part turns, beyond what the surface shows, before it
// ends at the other; none where that is more often than c.most, or others do not close after one turn.
std::optional<int> turns_at(const GluingCondition& c, const std::vector<const Way*>& ways);

// All gluings of all regions that take part in some conditions. A GluingProblem.
class GluingSearch {
 public:
  using Accept = std::function<bool(const std::vector<const Way*>&)>;

  // cells: of each region, in front (outside) and behind (inside); layers: of each cell, one more inside than
  // outside. accept: what else must hold once all regions are glued; others are then tried, too. All but the
  // conditions must outlive the search.
  GluingSearch(std::vector<GluingCondition> conditions, const std::vector<std::array<Index, 2>>& cells,
               const std::vector<int>& layers, const RunContext& context, Accept accept = nullptr);

  // most: gluings of single regions looked at before the search gives up.
  SolverAnswer run(std::int64_t most);

  std::int64_t steps() const { return work_.steps; }
  // Of `none`: the conditions that the search has needed, with their weights: a search for fewer begins
  // there.
  std::vector<GluingCondition> needed() const;

  // For the solver; see there.
  bool is_open(Index r) const { return !way_[r]; }
  std::optional<std::vector<Index>> possible(Index r, Index& blame);
  bool list_options(Index) { return true; }  // they are listed
  void choose(Index r, Index option) { way_[r] = &ways_[r][option]; }
  void clear(Index r) { way_[r] = nullptr; }
  double rank(Index r, std::size_t options) const;
  template <class F>
  void each_beside(Index r, F&& f) const {
    for (const Index k : of_[r]) conditions_[k].each([&](Index other) { f(other, 0); });
  }
  template <class F>
  void weigh(Index condition, F&& again) {
    ++weight_[condition];
    conditions_[condition].each(again);
  }
  bool accepts() const { return !accept_ || accept_(way_); }
  bool exhausted();

 private:
  bool is_known(const GluingCondition& c) const;
  void list_ways();

  std::vector<GluingCondition> conditions_;
  const std::vector<std::array<Index, 2>>& cells_;
  const std::vector<int>& layers_;
  const RunContext& context_;
  const Accept accept_;
  std::vector<Index> regions_;
  std::vector<std::vector<Index>> of_;  // conditions of each region
  std::vector<std::vector<Way>> ways_;  // of each region
  std::vector<const Way*> way_;         // the one chosen
  std::vector<double> weight_;          // of each condition
  std::vector<char> used_;
  struct Work {
    std::int64_t steps = 0, end = 0;  // gluings looked at; when to give up
    std::int64_t chosen = 0;
  };
  Work work_;
};

}  // namespace overtet

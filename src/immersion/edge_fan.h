// Fans: the facets around one edge of the arrangement, and whether copies of cells pass it rightly.
#pragma once

#include <array>
#include <compare>
#include <deque>
#include <vector>

#include "overtet/types.h"
#include "src/covering/gluing_solver.h"
#include "src/immersion/sheets.h"

namespace overtet {

// A region's gluing as Region has it: back_of per front copy, front_of per back copy.
struct Gluing {
  std::vector<int> back_of, front_of;
};

// The number of gluings of a region, in doubles since it grows like a factorial; 0 when there is none.
double count_gluings(const Region& region, Named named);

// Appends all gluings of the region's front copies to its back copies with its sheets ending in between.
void enumerate_gluings(const Region& region, Named named, std::deque<Gluing>& out);

// One edge of the arrangement with all facets around it.
struct Fan {
  struct Leaf {
    Index region;
    bool flipped;
    std::vector<Index> slots;  // region slot of each local sheet
    auto operator<=>(const Leaf&) const = default;
  };
  // A sheet arrives at leaf `from`, slot `from_sheet`, and must leave at the other after `turns` extra turns.
  struct Pass {
    int from, from_sheet, to, to_sheet, turns;
    auto operator<=>(const Pass&) const = default;
  };
  std::vector<Leaf> leaves;
  std::vector<std::array<int, 2>>
      arc;  // per leaf and side (0 front, 1 back): 2 * leaf + side it faces, or -1
  std::vector<Pass> passes;
  auto operator<=>(const Fan&) const = default;
};

// Follows every copy around the edge: whether each pass arrives after its turns and all other copies close
// after one turn. chosen: per region, its gluing. turns_wanted: what every pass must make instead of its own
// number, if not negative.
bool satisfied(const Fan& fan, const std::vector<const Gluing*>& chosen, const std::vector<Region>& regions,
               int turns_wanted = -1);

}  // namespace overtet

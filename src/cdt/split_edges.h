// The same facets with more points on them, for where TetGen finds no way to keep them whole.
#pragma once

#include <optional>
#include <vector>

#include "src/cdt/tetgen.h"

namespace overtet {

struct SplitPlc {
  Plc plc;  // the first points are the complex's; facets that were not cut keep their corners
  std::vector<Index> source;  // of each facet: the complex's facet that it is part of
};

// Cuts in half every edge of a facet that is no edge of the Delaunay tets of all points. Long edges past
// which many points lie are what TetGen has to fight for; their halves mostly need no fight. A middle is
// rounded, so cut facets bend by the last bit. None where no edge is missing, where bent facets would touch
// each other, or when the context says stop.
std::optional<SplitPlc> split_missing_edges(const Plc& plc, const RunContext& context);

}  // namespace overtet

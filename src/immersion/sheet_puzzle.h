// What the gluings of all regions between the cells of an arrangement must satisfy.
#pragma once

#include <array>
#include <vector>

#include "overtet/types.h"
#include "src/immersion/edge_fan.h"
#include "src/immersion/vertex_link.h"

namespace overtet {

// A fan over which sheets pass at input edges that may be wound: any number of extra turns, the same at all
// fans of an edge.
struct FreeFan {
  Fan fan;
  std::vector<Index> edges;  // per pass of the fan: the number of such an edge; -1: as many turns as it says
};

struct SheetPuzzle {
  std::vector<std::array<Index, 2>>
      cells;  // per region, in front of it and behind it; -1: outside everything
  std::vector<Fan> fans;
  std::vector<FreeFan> free_fans;
  Index free_edges = 0;           // how many there are
  std::vector<char> pierced;      // per free edge: something crosses its inside
  std::vector<VertexLink> links;  // where more than fans must be seen to
};

}  // namespace overtet

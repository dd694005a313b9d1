// Faces turned so that neighbours run along their edges in opposite directions.
#pragma once

#include <array>
#include <vector>

#include "overtet/types.h"
#include "src/cleanup/raw_edges.h"

namespace overtet {

// A shell: faces joined by edges that have two.
struct Oriented {
  std::vector<Index> shell_of;  // #F: shells are numbered by their smallest face
  std::vector<char> turned;     // #F: 1 where the last two corners must be swapped
  Index turned_faces = 0;
  std::vector<std::array<Index, 2>>
      one_sided;  // of each shell without an orientation: two faces that disagree
};

// In each shell the fewer faces are turned; where halves are equal, those that differ from the smallest face.
Oriented orient(const TriangleMatrix& F, const RawEdges& edges);

}  // namespace overtet

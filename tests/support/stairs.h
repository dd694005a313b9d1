// A surface with hinges whose answer is known because its tets are made first.
//
// Sectors are stacked around an axis like the steps of spiral stairs, tet by tet, for more than a full turn.
// The axis is a chain of boundary edges around which the tets make the whole angle, so the surface winds
// around it floor(turns) times more than it shows, and both its ends are hinges with just that integer B0.
// All tets are positive and every interior edge has one turn around it: the mesh is a solution, whatever the
// surface looks like.
#pragma once

#include <cstdint>
#include <vector>

#include "overtet/types.h"

namespace overtet::test {

struct StairsOptions {
  double turns = 1.3;  // not an integer
  int edges = 1;       // of the axis
  int per_turn = 7;    // steps
  double longer = 0;   // more turns around the last edge, so that two chains end at the vertex before it
  double bend = 0;     // radians that the axis bends by from each edge to the next
  double noise = 0;    // each coordinate moves by at most half of it, as long as all tets stay positive
  std::uint64_t seed = 1;
};

struct Stairs {
  Surface surface;
  TetMesh mesh;             // a solution
  std::vector<Index> axis;  // vertices, from hinge to hinge
  int wound = 0;            // extra turns around each edge of the axis
  int wound_last = 0;       // around its last one
};

Stairs spiral_stairs(const StairsOptions& options);

}  // namespace overtet::test

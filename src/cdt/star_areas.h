// Flat parts of a surface that are triangulated with needles, in pieces of which one point sees all.
//
// Prints, extrusions and CAD parts have faces of thousands of corners, triangulated as fans or by clipping
// ears: needles of 36,000:1 and more, all in one plane. A tet mesh has no trouble with them, since from a
// point just inside each is the base of a tet; what TetGen does to recover them one by one may never end.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct StarArea {
  std::vector<Index> faces;    // connected, in one plane up to rounding
  std::vector<Index> outline;  // vertices, each once; counter-clockwise seen from outside
  Eigen::Vector3d centre;      // in the plane; sees each edge of the outline from its inner side
  Eigen::Vector3d inwards;     // unit normal
};

// Areas with many needles each, which have no face in common. Needles may be left over; empty where there
// are none. Chosen in doubles: who uses an area checks what it must be. pre: `surface` is closed, oriented
// and manifold. Errors: limit or interrupted.
Result<std::vector<StarArea>> find_star_areas(const Surface& surface, const RunContext& context);

}  // namespace overtet

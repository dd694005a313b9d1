// Cutting with a tolerance, for surfaces that nearly coincide: where the exact curves in which they cross
// depend on the last bits of the coordinates, points and edges closer than the tolerance are taken to touch.
//
// One round: every vertex closer than the tolerance to a piece becomes a vertex of it, two edges closer than
// that get a vertex in common, an edge that pierces a piece a vertex where it does; pieces that then have
// three or more vertices in common are triangulated alike. So pieces leave the plane of their face by a
// tolerance. When no round changes anything, everything that does not touch is farther apart than the
// tolerance: rounding does no harm any more. (Snap rounding, Hobby 1999 and Guibas and Marimont 1998, carried
// over to triangles in space.)
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/arrangement/pieces.h"

namespace overtet {

struct ToleranceRound {
  Index cut = 0;       // pieces that were cut
  Index touching = 0;  // times that a vertex was nearer than the tolerance to a piece, or an edge to an edge
};

enum class CutIf {
  touching,  // something touches: nothing is cut where only crossings are to be cut
  anything   // anything touches or crosses
};

// points, pieces: the complex; new points come after all present ones. Only pieces marked `fresh` are
// compared with others; afterwards those that changed are. pre: no two vertices of different pieces are
// nearer than the tolerance. No piece cut: nothing was to be done. Errors: limit, interrupted, unsolved.
Result<ToleranceRound> cut_with_tolerance(std::vector<Eigen::Vector3d>& points, std::vector<Piece>& pieces,
                                          double tolerance, CutIf when, const RunContext& context);

}  // namespace overtet

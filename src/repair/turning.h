// Parts of a surface that are inside out over more than a vertex can be smoothed away from: a tube or a tip
// whose wall faces inwards, a dome pushed out through the far side. Internal to src/repair.
//
// Such a part bounds a region of negative winding number, with walls that face each other across it. Turning
// it moves the walls through each other along one direction, each half of the way and a little more, so that
// the region has positive thickness afterwards: a reflection, squashed. One direction for a whole part:
// moving every point along its own normal to the opposite wall would turn a tube by half a turn around its
// axis and leave it inside out. Least squares over pairs of opposite points decide how far each vertex goes,
// so that long thin faces and curved parts keep their walls apart everywhere.
#pragma once

#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/surface/diagnose.h"

namespace overtet {

struct InsideOutPart {
  std::vector<Index> faces;     // sorted
  std::vector<Index> vertices;  // sorted
  double negative_area = 0;     // of those faces, in front of which the winding number is negative
  Eigen::Vector3d across[2];    // span the plane in which the walls' normals lie, the main one first
};

struct Turn {
  std::vector<Index> vertices;  // sorted
  VertexMatrix to;              // their new positions
  double farthest = 0;          // the largest move
};

// Candidates, the one with the most negative area first. diagnosis: of the surface, complete.
std::vector<InsideOutPart> inside_out_parts(const Surface& surface, const Diagnosis& diagnosis,
                                            const RunContext& context);

// The part turned along cos(angle) across[0] + sin(angle) across[1]; its walls end up `thickness` times as
// far apart as they were. No vertices when no two walls face each other along that direction, or when all
// that do are closer than `thin`.
Turn turned(const Surface& surface, const InsideOutPart& part, double angle, double thickness, double thin);

}  // namespace overtet

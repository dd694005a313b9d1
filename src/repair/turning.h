// Parts of a surface that are inside out over more than a vertex can be smoothed away from: a tube or a tip
// whose wall faces inwards, a dome pushed out through the far side. Internal to src/repair.
//
// Such a part bounds a region of negative winding number, with walls that face each other across it. Turning
// it moves the walls through each other along one direction, each half of the way and a little more, so
// that the region has positive thickness afterwards: a reflection, squashed. One direction for a whole part:
// moving every point along its own normal to the opposite wall would turn a tube by half a turn around its
// axis and leave it inside out. Least squares over pairs of opposite points decide how far each vertex goes,
// so that long thin faces and curved parts keep their walls apart everywhere.
#pragma once

#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/diagnose.h"

namespace overtet {

// A point of a part's face.
struct WallSample {
  Index face = -1;  // of the surface
  Eigen::Vector3d at, normal;
  double weights[3] = {};  // barycentric
  double area = 0;
};

struct InsideOutPart {
  std::vector<Index> faces;     // sorted
  std::vector<Index> vertices;  // sorted
  std::vector<WallSample> samples;
  double negative_area = 0;  // of those faces, in front of which the winding number is negative
  // A wall that faces inwards all over, with creases where it begins; else all that surrounds one region of
  // negative winding, whose walls have come through each other.
  bool creased = true;
  std::vector<Eigen::Vector3d> directions;  // worth turning it along
};

struct Turn {
  std::vector<Index> vertices;  // sorted
  VertexMatrix to;              // their new positions
  double farthest = 0;          // the largest move
};

// Candidates, the one with the most negative area first. diagnosis: of the surface, complete.
std::vector<InsideOutPart> inside_out_parts(const Surface& surface, const Diagnosis& diagnosis,
                                            const RunContext& context);

// The part turned along a unit direction. Its walls end up `thickness` times as far apart as they were, where
// it is creased; else that part of the largest distance, everywhere. No vertices when no two walls face
// each other along that direction, or when all that do are closer than `thin`.
Turn turned(const Surface& surface, const InsideOutPart& part, const Eigen::Vector3d& along, double thickness,
            double thin);

}  // namespace overtet

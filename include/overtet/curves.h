// The curves in which the surface passes through itself, traced exactly.
//
// A pair of faces meets in a segment. Its ends are where an edge of one face meets the other face, and that
// edge leads to the next pair: so segments are joined by (edge, face), never by how close their ends are. A
// curve is closed, or ends at hinges (vertices whose one-ring crosses itself), or, in special
// position, where the surface only touches itself or where more than two segments meet. Every curve is seen
// twice on the surface, once on each of the two sheets that cross in it: its preimages.
//
// Third sheets cut curves into pieces (triple points, which are junctions of three curves). Around a piece
// the winding number takes four values: w in front of both faces, w + 1 in front of one and behind the other,
// w + 2 behind both.
//
// Exact: which segments there are, how they connect, where third faces cut them, the winding numbers.
// Rounded: positions and lengths (in the surface's units), barycentric coordinates. The result does not
// depend on the number of threads. docs/theory.md says what the winding numbers around curves are good for.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// A point of the surface: barycentric coordinates in a face, 0 where it lies on the edge opposite.
struct SurfacePoint {
  Index face = -1;
  std::array<double, 3> barycentric{};
};

struct CurveNode {
  enum class Kind {
    edge,    // an edge of one sheet passes through the other
    vertex,  // a vertex of one sheet lies on the other
    hinge,   // a vertex of both sheets: the curve ends there
    triple   // a third sheet passes
  };
  Kind kind = Kind::edge;
  std::array<double, 3> position{};
  std::array<SurfacePoint, 2> on;  // the preimages, sheet by sheet
  Index vertex = -1;               // of kind vertex or hinge
  Index junction = -1;             // into Curves::junctions, where curves meet
};

struct CurveSegment {
  std::array<Index, 2> faces{-1, -1};  // sheet by sheet
  // Both faces pass through each other. Otherwise the segment runs along an edge, where the surface may only
  // touch.
  bool crossing = true;
  int winding_min = 0,
      winding_max = 0;         // of the space around it; max = min + 2 where only the two faces meet
  bool winding_known = false;  // false: no ray could be counted there (not seen so far)
};

struct Curve {
  // How a curve ends: at a hinge, or at a contact, which only surfaces in special position have.
  enum class End { none, hinge, contact };
  bool closed = false;
  // Of a closed curve: after one time around, the sheets have changed places, so that the two preimages
  // are one loop of twice the length.
  bool sheets_swap = false;
  std::array<End, 2> ends{End::none, End::none};
  std::vector<CurveNode> nodes;        // closed: the first one is not repeated
  std::vector<CurveSegment> segments;  // segment i from node i to node i + 1 (or to the first)
  double length = 0;
  int winding_min = 0, winding_max = 0;  // over all segments with known ones
};

// A point where curves meet, or one curve meets itself: a triple point where three strands pass.
struct Junction {
  std::array<double, 3> position{};
  std::vector<std::pair<Index, Index>> strands;  // (curve, node), sorted
};

struct Curves {
  std::vector<Curve> curves;  // by the smallest pair of faces
  std::vector<Junction> junctions;
  Index touching_pairs = 0;  // pairs of faces that have one point in common
  Index coplanar_pairs = 0;  // pairs that lie on each other: their outline is made of other pairs
  double length = 0;

  Index closed() const;
  Index hinge_to_hinge() const;
  Index triple_points() const;  // junctions of three strands or more
};

// The curves of a closed, oriented, manifold surface of faces with area. Errors: bad_input (another surface;
// the message names the element), limit, interrupted, internal. Never throws.
Result<Curves> intersection_curves(const Surface& surface, const RunContext& context = {});

}  // namespace overtet

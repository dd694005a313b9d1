// Surfaces made usable by steps that do change the shape, each of them asked for: cracks closed, holes
// filled, specks dropped, needles collapsed. What changes no shape is done by the clean-up (cleanup.h), which
// runs before, between and after them. docs/raw-surfaces.md says what each step guarantees.
//
// Guaranteed: a vertex that no step names keeps its bits, and a face its corners. Nothing that is filled or
// collapsed crosses or touches what is there (unless allowed): where it would, the place stays as it is, and
// the record says where and why. That is decided exactly. Same surface, same options: same result, on any
// number of threads. Time is near-linear in the size of the surface, and grows with the square of a hole's
// number of edges.
//
// Holes are triangulated, refined and faired by CGAL's Polygon Mesh Processing [Liepa 2003; Zou, Ju, Carr
// 2013; Botsch, Kobbelt 2004], needles collapsed and flipped by it. It sees the surroundings of a place only.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "overtet/cleanup.h"
#include "overtet/io.h"
#include "overtet/report.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// In the order in which they run.
enum class PrepareStep { weld, close_cracks, remove_small, largest, fill_holes, collapse_needles };
const char* name_of(PrepareStep step);  // as in the report, for instance "fill-holes"

// Lengths are relative to the diagonal of the bounding box. 0, or false: the step is left out.
struct PrepareOptions {
  // Vertices of holes and borders that are no farther apart become one, where that closes edges. Others stay
  // apart, however near they are. Up to 0.1.
  double weld = 0;
  // As welding at the tolerance; and where a vertex of a border lies beside an edge of another face's, that
  // edge is split there.
  bool close_cracks = false;
  // Components with fewer faces are dropped; never the one with the largest area.
  Index remove_small = 0;
  bool largest = false;  // all components are dropped but the one with the largest area; cavities, too
  Index fill_holes = 0;  // holes with at most so many edges are filled; 0, or 3 to 5000
  // Needles are collapsed or flipped where the surface moves by no more than the tolerance.
  bool collapse_needles = false;

  double tolerance = 1e-4;       // of close_cracks and collapse_needles; up to 0.1
  double needle_degrees = 1;     // a face with a smaller angle is a needle; up to 30
  bool allow_crossings = false;  // fillings may cross the surface
  int most_places = 10;          // of each step that are listed, 1 to 1000000

  // All steps that suit any surface, with what is usual: cracks, components of fewer than 10 faces, holes of
  // at most 100 edges, needles.
  static PrepareOptions all();
  bool any() const {
    return weld > 0 || close_cracks || remove_small > 0 || largest || fill_holes > 0 || collapse_needles;
  }
  Status validate() const;  // Errors: usage.
};

// A place that a step left as it is.
struct PlaceLeft {
  std::array<double, 3> position{};
  Index vertex = -1;       // of the given surface, -1: a new one
  std::int64_t edges = 0;  // of a hole
  std::string why;         // "it has more than 100 edges"
};

struct PrepareRecord {
  PrepareStep step = PrepareStep::weld;
  double seconds = 0;
  std::int64_t done = 0, left = 0;  // vertices merged, components, holes or needles, as the step says
  std::vector<Figure> figures;      // what else was counted
  std::vector<PlaceLeft> places;    // the first ones of those left
  std::string message;              // one sentence
};

struct Preparation {
  // The surface that came out. Its maps lead to the given surface; -1: a vertex or face that is new. A face
  // that was split is there for each piece. `defects` has what was found at the very beginning, in numbers
  // of the given surface; there is no problem.
  Cleanup result;
  std::vector<PrepareRecord> steps;  // those that were asked for, in order
  std::vector<Index> moved;          // vertices of the result that are not where the given one's are, sorted
  // What is wrong still, in numbers of the result (its messages, too). Empty: it is closed, oriented,
  // manifold.
  std::vector<Defect> remaining;
};

// source: how messages call vertices and faces. Errors: usage (options), bad_input (malformed or one-sided),
// limit, interrupted. Never throws.
Result<Preparation> prepare(const Surface& surface, const PrepareOptions& options,
                            const SurfaceSource& source = {}, const RunContext& context = {});

}  // namespace overtet

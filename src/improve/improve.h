// Makes the tets of a valid mesh fit for simulation without touching its boundary.
//
// What it does, worst tets first: edge removal and 2-3 flips, optimisation of vertex positions (the worst
// dihedral sine of the star), contraction of interior edges, insertion of vertices into cavities, in the
// manner of Klingner and Shewchuk, "Aggressive Tetrahedral Mesh Improvement" (2008). Every change makes
// the worst of the tets that it replaces better, so the pass never makes a mesh worse.
//
// Guaranteed: see src/tet_complex/local_operations.h; in short, boundary vertices, edges and faces stay as
// they are, every tet stays exactly positive, interior edges keep their one turn, also at each moment in
// between: the mesh is valid whenever this stops.
// Same mesh and options, same result; one thread. (Only the time limit can break this.)
#pragma once

#include <vector>

#include "kernels/tet_energy/tet_quality.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/tet_complex/tet_complex.h"

namespace overtet {

struct ImproveOptions {
  double target_degrees = 15;  // tets with a dihedral angle below this, or above 180 - this, are worked on
  int passes = 12;             // over the bad tets
  bool insert_vertices = true;
  double insert_below_degrees = 10;  // vertices are inserted for tets this bad only
  double growth = 1.5;               // at most this many times the tets given
  // At most this many times the tets given are worked on, so that needles of the boundary that nothing can
  // improve cost a bounded effort. A count and not a time: the result must not depend on the machine.
  double effort = 4;
  // Of wall time, where the caller wants one; at most half of what the context has left is used.
  double seconds = 1e9;

  Status validate() const;
};

struct ImprovePass {
  std::int64_t bad = 0;  // tets below the target when the pass began
  double worst_sine = 0;
  std::int64_t removed_edges = 0, flips = 0, smoothed = 0, collapsed = 0, inserted = 0;
  double seconds = 0;
};

struct ImproveResult {
  enum class End { target_reached, no_progress, passes_done, effort_spent, time_over };
  End end = End::passes_done;
  DihedralStatistics before, after;
  std::vector<ImprovePass> passes;
  double seconds = 0;
};

// Works in place. Vertices that lose all their tets stay in the list until compact().
// Errors: usage (options), interrupted, limit (the context's deadline had passed on entry).
// pre: every tet positive.
Result<ImproveResult> improve(TetComplex& mesh, const ImproveOptions& options, const RunContext& context);

}  // namespace overtet

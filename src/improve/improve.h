// Makes the tets of a valid mesh fit for simulation without touching its boundary.
//
// What it does: first Delaunay refinement of the inside (refine.h); then, worst tets first, edge removal and
// 2-3 flips, optimisation of vertex positions (the worst dihedral sine of the star), contraction of interior
// edges, insertion of vertices into cavities, in the manner of Klingner and Shewchuk, "Aggressive Tetrahedral
// Mesh Improvement" (2008). Every change makes the worst of the tets that it replaces better, so the passes
// never make a mesh worse.
//
// Guaranteed: see src/mesh/local_operations.h; in short, boundary vertices, edges and faces stay as
// they are, every tet stays exactly positive, interior edges keep their one turn, also at each moment in
// between: the mesh is valid whenever this stops.
//
// A large mesh is cut into parts (src/mesh/partition.h) that are worked on at the same time; then what is
// left around the cuts is, in fewer parts, and so on: first the refinement of all, then the passes. Last,
// the worst tets that are left are looked at with all that is around them, piece by piece, by the dearest
// means, and the very worst by changes that make something worse at first (worst_places.h). Where after all
// this too many tets are bad, and fewer can be, some are given up for the others (trade.h): the one step that
// makes tets worse, though none worse than a part of the angle that counts as good. How many parts depends on
// the number of tets, not on that of threads: same mesh and options, same result. (Only a time limit can
// break this.)
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/tet_energy/tet_quality.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// How large tets may be: infinite or empty for no limit. Lengths and volumes in the user's unit: what `unit`
// times the coordinates is. Where the boundary's own edges are longer, tets get smaller inwards
// (src/mesh/size_limit.h).
struct SizeOptions {
  double max_volume = std::numeric_limits<double>::infinity();
  double max_edge = std::numeric_limits<double>::infinity();
  std::vector<double> at_surface;  // of each vertex of the surface: the longest edge there; it grows inwards
  Eigen::Vector3d unit = Eigen::Vector3d::Ones();

  bool any() const { return std::isfinite(max_volume) || std::isfinite(max_edge) || !at_surface.empty(); }
};

// More than 12 members: flat options, which callers set by name.
struct ImproveOptions {
  // Circumradius over shortest edge that refinement aims at; 0: no refinement.
  double radius_edge = 2.0;
  double target_degrees = 17;  // tets with a dihedral angle below this, or above 180 - this, are worked on
  int passes = 12;             // over the bad tets
  bool insert_vertices = true;
  double insert_below_degrees = 10;  // vertices are inserted for tets this bad only
  double growth = 1.5;               // at most this many times the tets that refinement leaves
  // Not more than this share of the tets is to have an angle below good_degrees, where that can be had by
  // giving some up; 1: no matter how many.
  double good_degrees = 10, bad_share = 0.05;
  // At most this many times the tets of a part are worked on, so that needles of the boundary that nothing
  // can improve cost a bounded effort. A count and not a time: the result must not depend on the machine.
  double effort = 4;
  // A mesh of more than twice as many is cut into parts: two for refinement, eight or more for the passes.
  std::int64_t tets_per_part = 40000;
  SizeOptions sizes;
  // So many vertices inside, the first after the surface's, lie where tets around them can be well shaped:
  // refinement works with them. Others are what making the mesh has left, perhaps too near to each other.
  Index placed = 0;
  bool coarse = false;  // in the end as few vertices inside as the target angle (and the sizes) allow
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

// More than 12 members: a plain record of what was done.
struct ImproveResult {
  enum class End { target_reached, no_progress, passes_done, effort_spent, time_over };
  End end = End::target_reached;  // of the part that ended worst
  DihedralStatistics before, after;
  std::int64_t thinned = 0;         // vertices that went because the mesh was overfull (coarsen.h)
  std::int64_t refined = 0;         // vertices that refinement inserted
  std::int64_t coarsened = 0;       // vertices that went because few were asked for
  std::int64_t too_large = 0;       // tets that are larger than asked, in spite of all
  std::int64_t fixed_too_long = 0;  // edges of the boundary that are longer than asked
  std::int64_t traded = 0;          // changes that made fewer tets bad (trade.h)
  int lifted = 0;  // times that a place with one of the worst tets got better at last (worst_places.h)
  std::vector<ImprovePass>
      passes;               // of all parts together: the n-th passes of a round of parts in one record
  std::vector<int> rounds;  // the number of parts in each round, of refinement, passes and looks
  double seconds = 0;
};

// Sizes: before the passes, tets that are too large get new vertices (sizes.h); all that comes after keeps to
// the limits.
//
// Works in place. The surface's vertices keep their numbers; others that no tet needs any more are dropped.
// Errors: usage (options), interrupted, limit (the context's deadline had passed on entry).
// pre: every tet positive.
Result<ImproveResult> improve(TetMesh& mesh, const ImproveOptions& options, const RunContext& context);

}  // namespace overtet

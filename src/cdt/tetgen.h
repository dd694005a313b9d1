// TetGen, run in a child process with a time and a memory limit.
//
// Debian's libtet is not a safe library call (it crashes, asserts, prints and keeps global state), so
// one call is one process. The input is scaled by a power of two into a fixed box and scaled back
// exactly; the first #V output vertices are verified to be the input's, to the last bit.
#pragma once

#include <array>
#include <vector>

#include "kernels/delaunay/delaunay.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// A piecewise linear complex whose facets are triangles. The caller guarantees: finite coordinates, no
// two equal vertices, no two facets that intersect except in shared vertices and edges.
struct Plc {
  VertexMatrix V;              // #V x 3
  TriangleMatrix F;            // #F x 3; internal facets are welcome
  std::vector<Index> markers;  // #F, > 0; handed through to TetgenResult::facet_markers; may be empty
  VertexMatrix holes;          // #H x 3; the region around each point stays empty
};

struct TetgenOptions {
  bool quality = true;            // insert interior points until radius_edge holds
  double radius_edge = 2.0;       // circumradius over shortest edge
  bool keep_facets = true;        // no added points on facets (TetGen -Y)
  bool accept_split = false;      // with keep_facets: take the result even where TetGen had to split facets
  bool accept_unused = false;     // vertices outside of what the facets enclose may stay without a tet
  bool fill_convex_hull = false;  // keep the tets outside the outermost facets (TetGen -c)
  double tolerance = 0;           // TetGen -T, for its coplanarity test; 0: TetGen's default
  Index largest_star = 0;         // of tets around an edge that its flips may take apart; 0: any
  double patience = 1;            // part of the work after which it is taken not to end; for what is a luxury
  bool free_points = false;       // with Delaunay tets first: with points off the facets (free_points.h)

  Status validate() const;
};

// More than 12 members: a record of figures beside the mesh.
struct TetgenResult {
  VertexMatrix V;         // #X x 3; the first #V rows are the input's, bit for bit
  TetMatrix T;            // #T x 4, positive
  TetMatrix neighbours;   // #T x 4; entry k: the tet beyond the face opposite to vertex k, or -1
  TriangleMatrix facets;  // subfaces of the input facets
  std::vector<std::array<Index, 4>> facet_on;  // #T, or empty where that was not found out by the way: the
                                               // row of facets on the face opposite to each vertex, or -1
  std::vector<Index> facet_markers;            // #facets
  std::vector<Index> facet_sources;            // #facets; the row of Plc::F that each is part of
  Index free_points = 0;                       // inside: the vertices that follow the input's
  Index missing_facets = 0;                    // no faces of the Delaunay tets, where those come first
  Index tetgen_facets = 0;                     // that TetGen has worked on, walls of cavities included
  Index parts = 1;                             // meshed one by one (domain_parts.h)
  std::int64_t predicates = 0;                 // that TetGen has called; 0: not in one call
  double seconds = 0;                          // wall time of the child
  std::size_t peak_rss_bytes = 0;              // of the child
};

// False where a face has an angle so small that refinement for quality would hardly end:
// TetgenOptions::quality is then better off. V: #V x 3, F: #F x 3.
bool worth_refining(const VertexMatrix& V, const TriangleMatrix& F);

// Guaranteed: every tet is exactly positive; every input vertex is a corner of some tet (without
// accept_unused); with keep_facets and without accept_split, `facets` are the input's facets (as vertex
// sets), each once. Errors: usage (options), bad_input (indices, infinite coordinates, equal vertices: the
// message names them), limit / interrupted (as the context says; the child is killed), unsolved (TetGen
// crashed, gave up or lost something; the message says which; ErrorReason::endless where it was given up, and
// might do with more patience), internal (the child program is missing).
Result<TetgenResult> tetrahedralize(const Plc& plc, const TetgenOptions& options, const RunContext& context);

// TetGen's coarsen-and-refine of a tet mesh that may overlap itself: all vertices from mesh.surface_vertices
// on are taken out, as far as flips can, and new ones put in until radius_edge holds; the boundary stays.
// Works on the tets as a complex, and by geometry around each place only, so that around edges inside the
// tets may make more turns afterwards than before. What TetGen makes twice is taken apart, so that the tets
// stay a manifold (src/cdt/manifold.h). Guaranteed: every tet exactly positive; the first vertices, and the
// faces of the boundary, unchanged to the last bit. Errors: unsolved (TetGen crashed, gave up or changed the
// boundary), limit, interrupted, internal. pre: every tet is positive.
Result<TetMesh> coarsen_and_refine(const TetMesh& mesh, double radius_edge, const RunContext& context);

// The same, several times where TetGen fails. Whether it finds its way through nearly degenerate facets
// depends on the order in which it sees the points, too, so the attempts turn the axes and shuffle the points
// (always in the same way), until several have not come to an end. The geometry stays the same to the last
// bit, and so do the promises.
Result<TetgenResult> tetrahedralize_shuffled(const Plc& plc, const TetgenOptions& options,
                                             const RunContext& context);

// Delaunay tets of a complex's first points and of free points.
struct DelaunayStart {
  DelaunayBuilder builder;   // of points, then of the free ones; empty: nothing is begun
  VertexMatrix free_points;  // #free x 3
};

// All means in turn. First without points inside, whatever options.quality says: that is fastest, but leaves
// flat tets where many points lie on a sphere; then with them, if options.quality allows it. Large inputs
// start from Delaunay tets (delaunay_first.h), and so do those where TetGen fails in every order. With
// options.free_points that is what is tried first, for those whose facets must stay whole whatever their
// size: some points inside cost little there, and spare those who refine the mesh much. Last, with
// accept_split, edges of facets that TetGen would have to fight for are cut in half (split_edges.h). All this
// with some patience first, and then with all of it. Of many facets there are fewer attempts, in proportion
// to options.patience. begun: from begin_delaunay() with the complex's first points, to the last bit.
Result<TetgenResult> tetrahedralize_stubbornly(const Plc& plc, const TetgenOptions& options,
                                               const RunContext& context, DelaunayStart begun = {});

// The serial part of large inputs, for while their last points are still being computed. V: the first ones,
// #V x 3; F: #F x 3, of which the facets will be pieces. Empty where that would not help or cannot be.
DelaunayStart begin_delaunay(const VertexMatrix& V, const TriangleMatrix& F, const RunContext& context);

}  // namespace overtet

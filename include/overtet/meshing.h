// The tet mesh of a closed surface that may pass through itself.
//
// Guaranteed of every mesh that is handed out, decided exactly on its doubles (verification.h has the rules):
// the surface's vertices come first, in their order and unmoved to the last bit; the boundary faces are the
// surface's faces, with its orientation; every tet is positive; the tets form a 3-manifold with boundary, and
// around every interior edge they make exactly one turn. Tets overlap in space where the surface does. With
// OnInfeasible::repair all of this holds for the surface with the vertices in `moved` at their new places,
// with OnInfeasible::refine for the surface `refined`; with OnInfeasible::branch all but the one turn around
// the edges in `branch_edges`, which are inside. The one exception is asked for by name: with allow_flips the
// tets in `flipped_tets` are not positive, and nothing is said of turns.
//
// Same surface and options: same mesh, to the byte, on any number of threads, as long as no deadline cuts the
// stage short (which is logged). Source: Sacht et al., "Consistent Volumetric Discretizations Inside
// Self-Intersecting Surfaces", 2013: section 3, equations 1 to 3, for what a mesh must satisfy, sections 3
// and 4 for the flow route. docs/immersion.md derives the immersion route.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "overtet/report.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "overtet/verification.h"

namespace overtet {

enum class Preset {
  standard,  // the immersion route, then the flow route if that finds no mesh
  flow,      // the flow route only
  paper      // the paper's recipe to the letter (PaperRecipe): no ladder of settings, nothing that unlocks
};

// Preset::paper, piece by piece, with the paper's parameters (Sacht et al. 2013, sections 4 and 5). The other
// piece of each kind is what the flow route uses, in its first setting.
struct PaperRecipe {
  enum class Forward {
    global,   // all vertices, plain cotangent weights
    regional  // only what is near a crossing
  } forward = Forward::global;
  enum class Reverse {
    pins,    // vertices of faces that would meet are put back and held, and pushed apart in the next step
    barrier  // faces are kept apart by a barrier
  } reverse = Reverse::pins;
  enum class Map {
    lim,   // locally injective mappings; tets never flip, but the boundary may not come home
    arap,  // volumetric as-rigid-as-possible: the boundary at home, but tets may be flipped
    pull   // that of the flow route
  } map = Map::lim;
  double delta = 1e-4;      // forward time step at unit area
  double repulsion = 1000;  // of faces that would meet; the paper: 1 to 1000
  double radius_edge = 2;   // of TetGen's tets
  int remesh_every = 100;   // iterations of lim between TetGen's coarsen-and-refine; 0: never
};
// How the flow route brings the mesh of its embedding to the surface.
enum class FlowMap {
  patch,  // what has moved is made anew, where it is to be; where that fails, the pull
  pull    // vertices are pulled to their places, every tet positive on the way
};
enum class OnInfeasible {
  reject,
  repair,  // move a few vertices a little
  // Where a mesh is only forbidden by the one turn around every interior edge, or by how the surface's faces
  // lie. Negative winding numbers and vertices with B0 < 0 forbid these, too (docs/theory.md).
  refine,  // the same shape, a few faces of it subdivided
  branch   // the surface as it is; around some interior edges (branch lines) the tets make two turns or more
};

// A surface with some faces subdivided.
struct RefinedSurface {
  Surface surface;                // the vertices come first, then those that were added
  std::vector<Index> face;        // of each face: the input's that it is, or is a piece of; increasing
  std::vector<Index> subdivided;  // the input's faces that are in pieces, sorted
};

// How large tets may be, in the surface's unit. The boundary stays as it is: where its own edges are longer
// than asked, so are edges near them, and tets get smaller inwards. Made by the quality pass.
struct TetSizes {
  double max_volume = 0;          // of a tet; 0: any
  double max_edge = 0;            // the longest edge inside; 0: any
  std::vector<double> at_vertex;  // #V: the longest edge at each vertex of the surface, which may grow by .4
                                  // of the distance from there; infinity: any. Empty: no sizes.
  bool coarse = false;            // as few vertices inside as improve_degrees (and the sizes) allow

  bool any() const { return max_volume > 0 || max_edge > 0 || !at_vertex.empty(); }
};

struct MeshingOptions {
  Preset preset = Preset::standard;
  PaperRecipe recipe;  // of Preset::paper
  FlowMap flow_map = FlowMap::patch;
  // What Preset::paper may leave wrong, and is otherwise an error that counts it. With allow_branches
  // interior edges around which the tets make two turns or more; with allow_flips tets that are not positive,
  // too. Both are listed (Meshing::branch_edges, flipped_tets), and a surface that has no mesh without them
  // is tried.
  bool allow_branches = false, allow_flips = false;
  OnInfeasible on_infeasible = OnInfeasible::reject;
  double max_repair_move = 0.06;  // of a vertex, relative to the diagonal of the bounding box; up to 1
  double improve_degrees = 17;  // smallest dihedral angle that the quality pass aims at, 0 to 40; 0: no pass
  TetSizes sizes;
  std::string save_stages;  // folder for the intermediate states; empty: none
  std::string resume;       // folder to take them from; empty: none
  // Folder for every state of the flows, as a film for ParaView (flow.pvd: V_0, V_t up to t*, and U_t back to
  // U_0); empty: none. Of the presets that flow.
  std::string save_flow;

  Status validate() const;  // Errors: usage. How many sizes there are is checked against the surface.
};

struct Meshing {
  TetMesh mesh;
  TetQuality quality;
  std::vector<Index> moved;      // vertices of the surface that a repair has moved, sorted
  double max_relative_move = 0;  // the largest move over the diagonal of the bounding box
  RefinedSurface refined;        // of OnInfeasible::refine, where faces were subdivided; else empty
  // Of OnInfeasible::branch and allow_branches: vertices of the mesh, a < b.
  std::vector<std::array<Index, 2>> branch_edges;
  std::vector<Index> flipped_tets;  // of allow_flips: those that are not positive; sorted
  std::string hash;                 // of the mesh's vertices and tets: 16 hexadecimal digits
};

// report: receives what the run did, even if there is no mesh. The caller fills in its `options`,
// `input.format` and `input.notes`.
// Errors: usage (options), bad_input (the message names the element), infeasible (Error::certificate has the
// proof), unsolved, limit, interrupted, io (stages), internal. Never throws.
Result<Meshing> tetrahedralize(const Surface& surface, const MeshingOptions& options = {},
                               const RunContext& context = {}, Report* report = nullptr);

}  // namespace overtet

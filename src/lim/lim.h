// The volumetric parameterisation with hard constraints (Sacht et al. 2013, section 4, the second choice):
// locally injective mappings [Schueller, Kavan, Panozzo, Sorkine-Hornung 2013] from the tet mesh of U0 to one
// whose boundary is V0.
//
//   minimise   E(x) + alpha |x_boundary - V0|^2 + beta sum_t phi(vol_t / vol_t at rest)
//
// over all vertices, E Green's strain of the tets, weighted by their volumes, phi a barrier that is infinite
// for a flat tet (kernels/tet_energy/strain_barrier.h). Newton's method with a definite Hessian and a line
// search that ends before the first tet would be flat; alpha grows while the boundary resists. Where that
// does not get on, or after so many iterations, TetGen coarsens and refines the present state
// (src/cdt/remesh.h), which becomes the rest state. It has succeeded when the boundary is so near to V0 that
// it can go there with every tet exactly positive.
//
// Lengths are in diagonals of the model. The paper does not give its settings; those of the published
// implementation are alpha = 1e3 times the energy over the constraints, at most 1e8, beta = .01.
//
// Guaranteed when it returns a value that `reached`: the first rows are V0, bit for bit, and every tet is
// exactly positive. Moves on the way are straight ones on which every tet stays positive, so that no edge
// gains a turn; a remeshing may make edges of two turns, and so may the last jump, where `jumped` says that
// it was not made vertex by vertex: these edges are for the caller to count. Same bytes on any number of
// threads.
#pragma once

#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct LimOptions {
  double alpha_ratio = 1e3, largest_alpha = 1e8;
  double barrier = 0.01;   // beta
  int iterations = 1000;   // at most
  int remesh_every = 100;  // iterations; 0: never
  int remeshes = 6;        // at most
  double radius_edge = 2;  // of TetGen's tets
  // Does not get on: so many iterations in turn without so much of the distance to V0 gone.
  int patience = 10;
  double progress = 0.1;
  double seconds =
      1e9;  // of wall time, for runs with a time limit: what there is by then is taken as the end

  Status validate() const;
};

struct LimIteration {
  double energy = 0;  // all terms
  double alpha = 0;
  double distance = 0;  // of the boundary to V0: root of the mean square, in diagonals
  double step = 0;      // part of Newton's step that was made
};

struct LimRemesh {
  int iteration = 0;  // after it
  Index tets_before = 0, tets = 0;
};

struct LimResult {
  enum class End { reached, stalled, iterations, time };
  End end = End::stalled;
  TetMesh mesh;             // where it has not reached V0: the state of the end, every tet positive
  bool jumped = false;      // the boundary went home at once
  std::vector<Index> away;  // boundary vertices that cannot go to their places one by one, ascending
  std::vector<LimIteration> iterations;
  std::vector<LimRemesh> remeshes;
};

// mesh: of stage tet_mesh, boundary U0. target: V0, as many rows as mesh.surface_vertices.
// Errors: usage, bad_input (sizes), limit, interrupted. Not to reach V0 is none.
Result<LimResult> lim(const TetMesh& mesh, const VertexMatrix& target, const LimOptions& options,
                      const RunContext& context);

}  // namespace overtet

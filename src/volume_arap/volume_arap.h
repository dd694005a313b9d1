// The volumetric parameterisation with the energy that punishes flipped tets, but finitely (Sacht et al.
// 2013, section 4, the first of the two choices): the boundary at V0, the inside where the
// as-rigid-as-possible energy of [Chao, Pinkall, Sanan, Schroeder 2010], with the tet mesh of U0 as rest
// state, is least; local-global, one factorisation.
//
// Guaranteed when it returns a value: the first rows are V0, bit for bit; `flipped` are exactly the tets that
// are not positive. None flipped does not mean that every interior edge makes one turn: that is for the
// caller to count. Same bytes on any number of threads.
#pragma once

#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct VolumeArapOptions {
  int iterations = 200;  // at most
  double still = 1e-5;   // ends when the energy falls by less than this part of it

  Status validate() const;
};

struct VolumeArapResult {
  TetMesh mesh;
  std::vector<Index> flipped;  // tets that are not positive, ascending
  int iterations = 0;
  double energy = 0;  // at the end, over the volume of the rest state
};

// mesh: of U0, every tet positive, its boundary vertices first. target: V0, as many rows as
// mesh.surface_vertices.
// Errors: usage, bad_input (sizes, a tet without volume in doubles), limit, interrupted.
Result<VolumeArapResult> volume_arap(const TetMesh& mesh, const VertexMatrix& target,
                                     const VolumeArapOptions& options, const RunContext& context);

}  // namespace overtet

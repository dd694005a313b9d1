// Tet meshes of large complexes in parts: TetGen meshes several at the same time.
//
// The parts are cut out of the Delaunay tets of all points, along faces of tets. A facet that is no face
// ("missing") passes through a few tets, which all go to the same part. So no facet crosses the faces between
// parts, no point has to be added there, and since they are Delaunay faces of each part's own points as well,
// TetGen has them from the start.
#pragma once

#include "src/cdt/delaunay_match.h"
#include "src/cdt/tetgen.h"

namespace overtet {

struct PartsOptions {
  Index facets_per_part = 20'000;
  double patience = 1;       // as TetgenOptions'
  bool accept_split = true;  // as TetgenOptions'
};

// What tetrahedralize() with keep_facets and without quality promises. Parts depend on the
// complex only, and the result is the same on any number of threads; as many parts as threads are in work.
// Errors: those of tetrahedralize(); unsolved also where the complex has less than half as many facets as a
// part should have, points on no facet, or missing facets that pass through very many tets.
Result<TetgenResult> mesh_in_parts(DelaunayMatch& match, const PartsOptions& options,
                                   const RunContext& context);

}  // namespace overtet

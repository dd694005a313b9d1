// Takes vertices that subdividing a surface has added off the boundary of its mesh again. Internal to
// src/pipeline.
#pragma once

#include <utility>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/mesh/subdivision.h"

namespace overtet {

struct MeshedSubdivision {
  Subdivision cut;
  std::vector<FacePoint> points;  // the added vertices
  TetMesh mesh;                   // of cut.surface
};

// The edges of made.cut.surface at added vertices that the mesh winds around; a < b, sorted.
std::vector<std::pair<Index, Index>> wound_edges(const MeshedSubdivision& made);

// The vertices that no wound edge needs leave; faces that nothing is left of are whole again. Nothing
// branches. surface: that was subdivided, in the same space. Errors: limit, interrupted.
Status drop_needless(const Surface& surface, const SurfaceTopology& topology, MeshedSubdivision& made,
                     const RunContext& context);

// All of them leave; wound edges at them become branch lines. False: digits do not suffice for one, and
// nothing has changed. Errors: limit, interrupted.
Result<bool> drop_all(const Surface& surface, const SurfaceTopology& topology, MeshedSubdivision& made,
                      const RunContext& context);

}  // namespace overtet

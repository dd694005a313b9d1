// Points in the free space around a surface, about as far from each other as from it.
//
// Tets of a surface's own vertices reach from one side of it to the other: each point that refinement puts in
// there later takes away hundreds of them, and most that it tries are in vain. With a few points there from
// the start, tets are as small as they are near the surface.
#pragma once

#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// The middles, moved a little, of the cells without faces in an octree whose other cells have a few vertices
// each; inside and outside of what the surface encloses. No two are equal, and none lies on a face or is a
// vertex. The same on any number of threads. V: #V x 3, F: #F x 3. Incomplete where the context says stop.
VertexMatrix free_points(const VertexMatrix& V, const TriangleMatrix& F, const RunContext& context);

}  // namespace overtet

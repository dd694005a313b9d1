// A mesh of a surface by way of another one close to it, for surfaces with parts that coincide.
//
// Where faces lie on each other, or rounding has put them there, the immersion has no layer between them, and
// where points of the surface nearly coincide, they may have no room to leave the boundary. On a surface
// whose vertices have moved a hair nothing coincides. So that one is meshed, and its mesh is pulled back to
// the input, every tet positive all the way, so that no edge gains a turn. Where there is no way back from
// one such surface, there may be one from another.
//
// What this finds is a mesh of the input like any other. What it does not find says nothing: not even that
// the surface nearby has none is a proof for the input.
#pragma once

#include "overtet/result.h"
#include "overtet/types.h"
#include "src/pipeline/meshing_job.h"

namespace overtet {

// Whether something of the surface may coincide with something else: what does crosses it, too. False where a
// part is known to have no mesh by itself.
bool may_coincide(const MeshingJob& job);

// A positive tet mesh of the surface, not yet checked.
Result<TetMesh> mesh_by_nearby_surface(const MeshingJob& job);

}  // namespace overtet
